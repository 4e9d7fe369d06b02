//! Runs a stock IDF over a weather file and prints zone temperatures.
use b2b_energyplus::{Event, Library, Run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let library = Library::load(a[1].as_ref())?;
    println!("{}", library.version());
    let json = library.convert_idf(a[2].as_ref())?;
    println!("{}", json.len());
    let zones = ["Core_ZN", "Attic"];
    let mut run = Run::new(&a[2], &a[3]);
    for z in zones {
        run = run.request("Zone Mean Air Temperature", z);
    }
    let mut sim = run.start(&library)?;
    println!("{:?}", sim.clock());
    let handles = zones.map(|z| sim.variable("Zone Mean Air Temperature", z).unwrap());
    let m = sim.meter("Electricity:HVAC")?;
    println!("{:?} {:?}", sim.meter("Electricity:Facility"), m);
    let mut n = 0;
    let t = std::time::Instant::now();
    while let Some(e) = sim.advance()? {
        n += 1;
        if n < 4 || n == 5000 {
            println!("{e:?} {:?} {:?} {}", sim.clock(), handles.map(|h| sim.read(h)), sim.read_meter(m));
        }
        if n == 8000 {
            sim.stop();
            println!("stopped")
        }
    }
    println!("{:?} {:?}", t.elapsed(), sim.messages());
    Ok(())
}

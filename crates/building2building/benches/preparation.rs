//! Making a building: drawing the dataset, generating a model, and making it controllable.
//!
//! `cargo bench -p building2building --bench preparation`

use std::hint::black_box;

use building2building::BuildingType;
use building2building::dataset::{Catalog, Places, rows, sample};
use building2building::energyplus::install::Quiet;
use criterion::{Criterion, criterion_group, criterion_main};

/// The buildings whose models are generated.
const IDS: [(BuildingType, usize); 2] =
    [(BuildingType::SingleFamilyHouse, 41), (BuildingType::OfficeSmall, 41)];

fn generation(criterion: &mut Criterion) {
    let catalog = Catalog::open(&mut Quiet).expect("the engine");
    for (building_type, index) in IDS {
        let building = &rows(building_type)[index].building;
        // The first time downloads the weather and converts the prototype.
        catalog.generate(building, &mut Quiet).expect("a model");
        criterion.bench_function(&format!("generate a {building_type}"), |bench| {
            bench.iter(|| black_box(catalog.generate(building, &mut Quiet)));
        });
    }
}

fn drawing(criterion: &mut Criterion) {
    criterion.bench_function("draw 100 houses", |bench| {
        bench.iter(|| black_box(sample(BuildingType::SingleFamilyHouse, 100, 0, &Places::All, &[])));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = generation, drawing
}
criterion_main!(benches);

//! Effectiveness of heat recovery at 75 % of the flow.
//!
//! Before 24.1, the effectiveness was a straight line through its values at 75 and 100 % of the nominal flow. Now a
//! curve of the flow multiplies the value at 100 %. The same line, divided by that value, is such a curve.

use crate::import::versions::document::{Document, Field, Object};
use crate::import::versions::report::Conversion;

const CLASS: &str = "HeatExchanger:AirToAir:SensibleAndLatent";

/// A kind of effectiveness.
struct Kind {
    name: &'static str,
    at_100: Field<'static>,
    at_75: Field<'static>,
    curve: Field<'static>,
}

const fn field(at: usize, name: &'static str) -> Field<'static> {
    Field { at, name }
}

/// The kinds, with positions before the step; curve positions are after the removal of the 75 % fields.
const KINDS: [Kind; 4] = [
    Kind {
        name: "Sensible Heating",
        at_100: field(4, "sensible_effectiveness_at_100_heating_air_flow"),
        at_75: field(6, "sensible_effectiveness_at_75_heating_air_flow"),
        curve: field(20, "sensible_effectiveness_of_heating_air_flow_curve_name"),
    },
    Kind {
        name: "Latent Heating",
        at_100: field(5, "latent_effectiveness_at_100_heating_air_flow"),
        at_75: field(7, "latent_effectiveness_at_75_heating_air_flow"),
        curve: field(21, "latent_effectiveness_of_heating_air_flow_curve_name"),
    },
    Kind {
        name: "Sensible Cooling",
        at_100: field(8, "sensible_effectiveness_at_100_cooling_air_flow"),
        at_75: field(10, "sensible_effectiveness_at_75_cooling_air_flow"),
        curve: field(22, "sensible_effectiveness_of_cooling_air_flow_curve_name"),
    },
    Kind {
        name: "Latent Cooling",
        at_100: field(9, "latent_effectiveness_at_100_cooling_air_flow"),
        at_75: field(11, "latent_effectiveness_at_75_cooling_air_flow"),
        curve: field(23, "latent_effectiveness_of_cooling_air_flow_curve_name"),
    },
];

pub(super) fn convert(document: &mut Document, version: &str, report: &mut Conversion) -> Vec<String> {
    let mut curves = Vec::new();
    for object in document.objects.iter_mut().filter(|object| object.is(CLASS)) {
        let lines: Vec<Option<[f64; 2]>> = KINDS.iter().map(|kind| line(object, kind)).collect();
        for kind in KINDS.iter().rev() {
            object.remove(kind.at_75);
        }
        for (kind, line) in KINDS.iter().zip(lines) {
            let Some(line) = line else { continue };
            let name = format!("{} {}", object.name(), kind.name);
            curves.push(curve(object, &name, line));
            object.set(kind.curve, &name);
            let what = "the effectiveness at 75 % of the flow is now a curve";
            report.changed(version, CLASS, what.to_owned());
        }
    }
    document.objects.extend(curves);
    Vec::new()
}

/// Returns intercept and slope of the effectiveness over the flow, relative to the value at 100 %; `None` if it is
/// constant.
fn line(object: &Object, kind: &Kind) -> Option<[f64; 2]> {
    let number = |field| object.get(field)?.parse::<f64>().ok();
    let full = number(kind.at_100).filter(|full| *full > 0.0)?;
    let part = number(kind.at_75).filter(|part| *part > 0.0)?;
    let slope = 4.0 * (full - part) / full;
    (slope != 0.0).then_some([1.0 - slope, slope])
}

fn curve(object: &Object, name: &str, [intercept, slope]: [f64; 2]) -> Object {
    let values = [
        ("coefficient1_constant", intercept.to_string()),
        ("coefficient2_x", slope.to_string()),
        ("minimum_value_of_x", "0".to_owned()),
        ("maximum_value_of_x", "2".to_owned()),
    ];
    Object::like(object, "Curve:Linear", name, &values)
}

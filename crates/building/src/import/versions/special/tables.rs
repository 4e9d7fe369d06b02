//! Tables of one variable, which are lookup tables since 9.2.

use serde_json::{Value, json};

use crate::import::versions::document::{Body, Document, Field, Object};
use crate::import::versions::report::Conversion;
use crate::model::begins;

const CLASS: &str = "Table:OneIndependentVariable";
/// Position of the first pair of values in an IDF.
const FIRST_PAIR: usize = 11;

pub(super) fn convert(document: &mut Document, version: &str, report: &mut Conversion) -> Vec<String> {
    let mut objects = Vec::new();
    for object in std::mem::take(&mut document.objects) {
        if object.is(CLASS) {
            objects.extend(lookup(&object));
            let what = "is now Table:Lookup, with its variable; values between are interpolated".to_owned();
            report.changed(version, CLASS, what);
        } else {
            objects.push(object);
        }
    }
    document.objects = objects;
    Vec::new()
}

/// Returns the lookup table, the list of its variable and the variable.
fn lookup(table: &Object) -> [Object; 3] {
    let text = |at, name| table.get(Field { at, name }).unwrap_or_default();
    let name = table.name();
    let (list, variable) = (format!("{name} Variables"), format!("{name} Variable"));
    let pairs = pairs(table);
    let reference = text(10, "normalization_reference");
    let divisor = if reference.is_empty() { "None" } else { "DivisorOnly" };
    let is_linear = begins(&text(3, "interpolation_method"), "Linear");
    let interpolation = if is_linear { "Linear" } else { "Cubic" };
    let no_file = ["external_file_name", "external_file_column_number", "external_file_starting_row_number"];
    let blank = no_file.map(|field| (field, String::new()));
    let mut of_table = vec![
        ("independent_variable_list_name", list.clone()),
        ("normalization_method", divisor.to_owned()),
        ("normalization_divisor", reference),
        ("minimum_output", text(6, "minimum_table_output")),
        ("maximum_output", text(7, "maximum_table_output")),
        ("output_unit_type", text(9, "output_unit_type")),
    ];
    of_table.extend(blank.clone());
    let mut of_variable = vec![
        ("interpolation_method", interpolation.to_owned()),
        ("extrapolation_method", "Constant".to_owned()),
        ("minimum_value", text(4, "minimum_value_of_x")),
        ("maximum_value", text(5, "maximum_value_of_x")),
        ("normalization_reference_value", String::new()),
        ("unit_type", text(8, "input_unit_type_for_x")),
    ];
    of_variable.extend(blank);
    let column = |index: usize| pairs.iter().map(|pair| pair[index].clone()).collect::<Vec<_>>();
    let object = |class, name: &str, values: &[(&str, String)]| Object::like(table, class, name, values);
    [
        with_values(
            object("Table:IndependentVariable", &variable, &of_variable),
            "values",
            "value",
            &column(0),
        ),
        with_values(
            object("Table:IndependentVariableList", &list, &[]),
            "independent_variables",
            "independent_variable_name",
            &[variable],
        ),
        with_values(object("Table:Lookup", &name, &of_table), "values", "output_value", &column(1)),
    ]
}

/// Returns the values of the variable and of the table, ordered by the first.
fn pairs(table: &Object) -> Vec<[String; 2]> {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let mut pairs: Vec<[String; 2]> = match &table.body {
        Body::Positions(values) => {
            let values = values.iter().skip(FIRST_PAIR - 1).cloned().collect::<Vec<_>>();
            values.chunks_exact(2).map(|pair| [pair[0].clone(), pair[1].clone()]).collect()
        }
        Body::Names { fields, .. } => {
            let items = fields.get("values").and_then(Value::as_array).into_iter().flatten();
            items
                .filter_map(|item| Some([text(item.get("x_value_1")?), text(item.get("output_value_1")?)]))
                .collect()
        }
    };
    let x = |pair: &[String; 2]| pair[0].parse::<f64>().unwrap_or(0.0);
    pairs.sort_by(|a, b| f64::total_cmp(&x(a), &x(b)));
    pairs
}

/// Adds values to an object: at the end of an IDF's, in a list of an epJSON's.
pub(super) fn with_values(mut object: Object, list: &str, field: &str, given: &[String]) -> Object {
    match &mut object.body {
        Body::Positions(values) => values.extend(given.iter().cloned()),
        Body::Names { fields, .. } => {
            let number =
                |value: &String| value.parse::<f64>().map_or_else(|_| json!(value), |number| json!(number));
            let items = given.iter().map(|value| json!({ field: number(value) })).collect();
            fields.insert(list.to_owned(), Value::Array(items));
        }
    }
    object
}

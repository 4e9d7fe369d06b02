//! Manifests as CSV and as Parquet, both with the same content.

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;

use anyhow::{Context, Result};
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{ArrayRef, ArrowPrimitiveType, BooleanArray, PrimitiveArray, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use b2b_dataset::manifest::{Column, Kind, Manifest};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

use crate::output_folder::OutputFolder;

/// Stages `NAME.csv` and `NAME.parquet`, and returns their names.
pub fn write(folder: &OutputFolder, name: &str, manifest: &Manifest) -> Result<[String; 2]> {
    let names = ["csv", "parquet"].map(|extension| format!("{name}.{extension}"));
    folder.write(&names[0], |file| Ok(file.write_all(manifest.to_csv().as_bytes())?))?;
    folder.write(&names[1], |file| write_parquet(file, manifest))?;
    Ok(names)
}

/// Writes nullable columns, with their units in the field metadata.
fn write_parquet(file: &mut (impl Write + Send), manifest: &Manifest) -> Result<()> {
    let schema = Arc::new(Schema::new(manifest.columns.iter().map(field).collect::<Vec<_>>()));
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(file, Arc::clone(&schema), Some(properties))?;
    let arrays = (0..manifest.columns.len()).map(|index| array(manifest, index)).collect::<Result<_>>()?;
    writer.write(&RecordBatch::try_new(schema, arrays)?)?;
    writer.close()?;
    Ok(())
}

fn field(column: &Column) -> Field {
    let data_type = match column.kind {
        Kind::Text => DataType::Utf8,
        Kind::Number => DataType::Float64,
        Kind::Integer => DataType::Int64,
        Kind::Flag => DataType::Boolean,
    };
    let unit = HashMap::from([("unit".to_owned(), column.unit.to_owned())]);
    Field::new(column.name, data_type, true).with_metadata(unit)
}

fn array(manifest: &Manifest, index: usize) -> Result<ArrayRef> {
    let column = &manifest.columns[index];
    let cells: Vec<_> =
        manifest.rows.iter().map(|row| Some(row[index].as_str()).filter(|cell| !cell.is_empty())).collect();
    let array: Result<ArrayRef> = match column.kind {
        Kind::Text => Ok(Arc::new(StringArray::from(cells))),
        Kind::Number => numbers::<Float64Type>(&cells),
        Kind::Integer => numbers::<Int64Type>(&cells),
        Kind::Flag => parsed(&cells).map(|flags| Arc::new(BooleanArray::from(flags)) as ArrayRef),
    };
    array.with_context(|| format!("column {} of the manifest", column.name))
}

fn numbers<T: ArrowPrimitiveType>(cells: &[Option<&str>]) -> Result<ArrayRef>
where
    T::Native: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>,
{
    Ok(Arc::new(PrimitiveArray::<T>::from_iter(parsed::<T::Native>(cells)?)))
}

fn parsed<T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>>(
    cells: &[Option<&str>],
) -> Result<Vec<Option<T>>> {
    cells.iter().map(|cell| Ok(cell.map(str::parse).transpose()?)).collect()
}

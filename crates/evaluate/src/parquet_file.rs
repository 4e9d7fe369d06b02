//! Reading of Parquet files, which may be damaged.

use std::fs::File;
use std::io::{self, Read};

use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use bytes::{Buf, Bytes, buf};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, Length};

use crate::panics::catch_panic;

/// Reads a Parquet file: its schema, which has the metadata, and its rows in batches.
///
/// # Errors
/// The errors of the Parquet library, which panics on some damaged files; such a panic is returned as an error too.
pub fn read_parquet(mut file: File) -> Result<(SchemaRef, Vec<RecordBatch>), ParquetError> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let read = || {
        let builder = ParquetRecordBatchReaderBuilder::try_new(Content(bytes.into()))?;
        let schema = builder.schema().clone();
        let batches = builder.build()?.collect::<Result<_, _>>()?;
        Ok((schema, batches))
    };
    catch_panic(read).unwrap_or_else(|panic| Err(ParquetError::General(format!("damaged: {panic}"))))
}

/// The content of a file. Reading beyond its end is an error; otherwise a wrong length in a damaged file could make the
/// library allocate too much memory or skip billions of missing values.
struct Content(Bytes);

impl Content {
    /// Returns the position if it is in the file.
    fn within(&self, position: u64) -> Result<usize, ParquetError> {
        let within = usize::try_from(position).ok().filter(|&position| position <= self.0.len());
        within.ok_or_else(|| ParquetError::EOF(format!("byte {position} of {}", self.0.len())))
    }
}

impl Length for Content {
    fn len(&self) -> u64 {
        self.0.len() as u64
    }
}

impl ChunkReader for Content {
    type T = UntilEnd;

    fn get_read(&self, start: u64) -> Result<UntilEnd, ParquetError> {
        Ok(UntilEnd { rest: self.0.slice(self.within(start)?..).reader(), reads_at_end: 0 })
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        let end = self.within(start.saturating_add(length as u64))?;
        Ok(self.0.slice(self.within(start)?..end))
    }
}

/// A reader that fails if it is read beyond the end.
struct UntilEnd {
    rest: buf::Reader<Bytes>,
    reads_at_end: usize,
}

impl Read for UntilEnd {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        const PATIENCE: usize = 100;
        let count = self.rest.read(buffer)?;
        self.reads_at_end += usize::from(count == 0);
        if self.reads_at_end > PATIENCE { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(count) }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Seek, Write};
    use std::sync::Arc;

    use arrow_array::types::Float64Type;
    use arrow_array::{ArrayRef, Float64Array, ListArray, StringArray};
    use parquet::arrow::ArrowWriter;

    use super::*;

    fn table() -> RecordBatch {
        let lists = ListArray::from_iter_primitive::<Float64Type, _, _>([Some([Some(1.0), Some(2.0)]), None]);
        let columns: [(&str, ArrayRef); 3] = [
            ("name", Arc::new(StringArray::from(vec!["a", "b"]))),
            ("number", Arc::new(Float64Array::from(vec![Some(1.5), None]))),
            ("list", Arc::new(lists)),
        ];
        RecordBatch::try_from_iter(columns).unwrap()
    }

    fn read(bytes: &[u8]) -> Result<Vec<RecordBatch>, ParquetError> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        file.rewind().unwrap();
        Ok(read_parquet(file)?.1)
    }

    #[test]
    fn damaged_files_are_read_or_are_errors() {
        let mut bytes = Vec::new();
        let mut writer = ArrowWriter::try_new(&mut bytes, table().schema(), None).unwrap();
        writer.write(&table()).unwrap();
        writer.close().unwrap();
        assert_eq!(read(&bytes).unwrap(), [table()]);

        let mut rejected = 0;
        for position in 0..bytes.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[position] = value;
                rejected += usize::from(read(&damaged).is_err());
            }
            rejected += usize::from(read(&bytes[..position]).is_err());
        }
        assert!(rejected > 2 * bytes.len(), "{rejected} of {}", 6 * bytes.len());
    }
}

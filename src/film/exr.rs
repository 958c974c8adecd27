//! [`ExrEncoder`]: encodes pictures of numbers as OpenEXR, row by row, by parts of the crate `exr`. Its writer wants all rows
//! within one call.
//!
//! An EXR file has a head, a table that says where each *chunk* begins, and the chunks: here one row each.

use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::error::Error;
use exr::meta::attribute::{ChannelDescription, LineOrder, SampleType};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{BlockDescription, MetaData, magic_number};
use std::io::{self, Seek, SeekFrom, Write};

/// Bytes of rows after which what is encoded is written.
const WRITTEN_AT_ONCE: usize = 1 << 20;
/// Bytes of a place in the table.
const PLACE_BYTES: u64 = 8;
/// The channels in the order of their names, as the format wants it, and which number of a pixel each is.
const CHANNELS: [(&str, usize); 3] = [("B", 2), ("G", 1), ("R", 0)];

/// Encodes a picture of three numbers a pixel.
pub struct ExrEncoder {
    header: Header,
    /// The head, and the places of the chunks so far. It is written last.
    start: Vec<u8>,
    /// Place of the next chunk.
    place: u64,
    /// Rows that are encoded.
    rows: usize,
}

impl ExrEncoder {
    /// Begins a picture of this size.
    ///
    /// # Errors
    /// As the library.
    pub fn new((width, height): (u32, u32)) -> io::Result<Self> {
        let size = (width as usize, height as usize);
        let channels = CHANNELS.map(|(name, _)| ChannelDescription::named(name, SampleType::F32));
        let header = Header::new("".into(), size, channels.into_iter().collect())
            .with_encoding(Compression::RLE, BlockDescription::ScanLines, LineOrder::Increasing)
            // A name is for files of several pictures.
            .with_attributes(LayerAttributes::default());
        let start = head(&header).map_err(io::Error::other)?;
        let place = start.len() as u64 + PLACE_BYTES * u64::from(height);
        Ok(Self { header, start, place, rows: 0 })
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// Those of the file, and more rows than the picture has.
    pub fn write_rows(&mut self, numbers: &[f32], file: &mut (impl Write + Seek)) -> io::Result<()> {
        let row_numbers = 3 * self.header.layer_size.0;
        let rows_at_once = (WRITTEN_AT_ONCE / (4 * row_numbers)).max(1);
        for rows in numbers.chunks(rows_at_once * row_numbers) {
            let mut chunks = Vec::new();
            file.seek(SeekFrom::Start(self.place))?;
            for row in rows.chunks_exact(row_numbers) {
                self.start.extend((self.place + chunks.len() as u64).to_le_bytes());
                self.encode(row, &mut chunks).map_err(io::Error::other)?;
            }
            file.write_all(&chunks)?;
            self.place += chunks.len() as u64;
        }
        Ok(())
    }

    fn encode(&mut self, row: &[f32], chunks: &mut Vec<u8>) -> Result<(), Error> {
        let pixels = row.as_chunks::<3>().0;
        let mut data = vec![0; 4 * row.len()];
        for (channel, (_, number)) in data.chunks_exact_mut(4 * pixels.len()).zip(CHANNELS) {
            let numbers = channel.as_chunks_mut().0.iter_mut();
            numbers.zip(pixels).for_each(|(bytes, pixel)| *bytes = pixel[number].to_ne_bytes());
        }
        let index = BlockIndex {
            layer: 0,
            pixel_position: (0, self.rows).into(),
            pixel_size: (pixels.len(), 1).into(),
            level: (0, 0).into(),
        };
        self.rows += 1;
        UncompressedBlock { index, data }.compress_to_chunk(std::slice::from_ref(&self.header))?.write(chunks, 1)
    }

    /// Writes what comes before the rows.
    ///
    /// # Errors
    /// Those of the file, and rows that are missing.
    pub fn finish(self, file: &mut (impl Write + Seek)) -> io::Result<()> {
        if self.rows < self.header.layer_size.1 {
            return Err(io::Error::other("rows are missing"));
        }
        file.seek(SeekFrom::Start(0))?;
        file.write_all(&self.start)
    }
}

/// Returns the head of a file.
fn head(header: &Header) -> Result<Vec<u8>, Error> {
    let mut head = Vec::new();
    let headers = std::slice::from_ref(header);
    let requirements = MetaData::validate(headers, true)?;
    magic_number::write(&mut head)?;
    requirements.write(&mut head)?;
    Header::write_all(headers, &mut head, requirements.is_multilayer())?;
    Ok(head)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_rows_and_more_than_all_are_errors() {
        for (rows, is_right) in [(1, false), (2, true), (3, false)] {
            let mut file = io::Cursor::new(Vec::new());
            let mut encoder = ExrEncoder::new((5, 2)).unwrap();
            let written = encoder.write_rows(&vec![1.0; 15 * rows], &mut file);
            assert_eq!(written.and_then(|()| encoder.finish(&mut file)).is_ok(), is_right, "{rows}");
        }
    }
}

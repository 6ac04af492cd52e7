//! Pictures that a run wrote, for pages that show them.

use std::path::Path;

use orograph_core::{Context, InputPath, Job, Node, OutputPath, Result, Texture};
use orograph_nodes::{
    io::{
        read_texture::ReadTexture,
        write_texture::{Packing, WriteTexture, WriteTextureIn},
    },
    look::contact_sheet::{ContactSheet, ContactSheetIn},
};

use crate::FolderHost;

/// The picture in a PNG file.
///
/// # Errors
/// When there is none to be read.
pub fn read(file: &Path) -> Result<Texture> {
    let host = FolderHost::new(Path::new(""));
    let node = ReadTexture { file: InputPath(file.to_string_lossy().into_owned()), ..ReadTexture::default() };
    Ok(node.run((), &Job::new(&host, Context::default()))?.texture)
}

/// Writes a picture as the file `name` in `folder`, packed small.
///
/// # Errors
/// When it cannot be written.
pub fn write(picture: &Texture, folder: &Path, name: &str) -> Result<()> {
    let host = FolderHost::new(folder);
    let node = WriteTexture { file: OutputPath(name.into()), packing: Packing::Small };
    node.run(WriteTextureIn { texture: picture }, &Job::new(&host, Context::default()))
        .map_err(|error| host.located(error))
}

/// The picture no wider than `width`.
///
/// # Errors
/// When there is no memory for it.
pub fn fitted(picture: Texture, width: u32) -> Result<Texture> {
    let (rows, cols) = picture.grid().size();
    if cols as u64 <= u64::from(width) {
        return Ok(picture);
    }
    let height = (rows as f64 / cols as f64 * f64::from(width)).round() as u32;
    let host = FolderHost::new(Path::new(""));
    let sheet = ContactSheet { size: width.max(height), spacing: 0, ..ContactSheet::default() };
    Ok(sheet.run(ContactSheetIn { pictures: vec![&picture] }, &Job::new(&host, Context::default()))?.picture)
}

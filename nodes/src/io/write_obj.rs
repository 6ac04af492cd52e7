//! Write OBJ: a mesh as text, with its material and texture beside it.

use std::io::{BufWriter, Write};

use orograph_core::{Mesh, OutputStream, prelude::*};

use super::{file, solid, write_gltf::y_up, write_texture};

/// The axis that points up.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// Up is y and north is -z: what Blender, Maya, Unity and most others expect.
    Y,
    /// Up is z and north is y: what CAD, printing and GIS expect.
    Z,
}

/// Writes a mesh as Wavefront OBJ in metres, with the material `NAME.mtl` and the texture `NAME_texture.png` beside it.
///
/// Numbers have all their digits. For large meshes glTF is several times smaller and quicker to read.
#[derive(Params, Clone, Debug)]
pub struct WriteObj {
    /// The file to write.
    #[param(default = "terrain.obj")]
    pub file: OutputPath,
    /// The axis that points up.
    #[param(default = Up::Y)]
    pub up: Up,
}

/// Inputs of [`WriteObj`].
#[derive(Inputs)]
pub struct WriteObjIn<'a> {
    /// Mesh to write.
    pub mesh: &'a Mesh,
    /// Colours that lie over the terrain that the mesh was made from; grey without.
    pub texture: Option<&'a Texture>,
}

impl Node for WriteObj {
    const ID: &'static str = "io.write_obj";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WriteObjIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["obj"])
    }

    fn run(&self, inputs: WriteObjIn<'_>, job: &Job) -> Result<()> {
        solid::check(inputs.mesh, inputs.texture, job)?;
        let stem = self.file.0.rsplit_once('.').map_or(self.file.0.as_str(), |(stem, _)| stem);
        // The files lie beside each other, so they name each other without folders.
        let bare = |name: &str| name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned();
        let beside = |end: &str| OutputPath(format!("{stem}{end}"));
        let (material, picture) = (beside(".mtl"), beside("_texture.png"));
        let text = material_text(inputs.texture.map(|_| bare(&picture.0)).as_deref());
        let mut files = Vec::new();
        if let Some(texture) = inputs.texture {
            files.push(begin(&picture, job, |out| write_texture::write(texture, out, &picture.0, job))?);
        }
        files.push(begin(&material, job, |out| {
            out.write_all(text.as_bytes()).map_err(|reason| Error::writing(&material.0, reason))
        })?);
        files.push(begin(&self.file, job, |out| {
            write(inputs.mesh, self.up, &bare(&material.0), out, &self.file.0, job)
        })?);
        // None appears before all are whole, and the one that names the others last.
        files.into_iter().try_for_each(|(path, out)| file::end(out, path, job))
    }
}

type Out = BufWriter<Box<dyn OutputStream>>;

/// Writes a file that does not appear yet.
fn begin<'a>(
    path: &'a OutputPath,
    job: &Job,
    fill: impl FnOnce(&mut Out) -> Result<()>,
) -> Result<(&'a OutputPath, Out)> {
    let mut out = file::begin(path, job)?;
    fill(&mut out)?;
    out.flush().map_err(|reason| Error::writing(&path.0, reason))?;
    Ok((path, out))
}

/// A dull material, coloured by the picture.
fn material_text(picture: Option<&str>) -> String {
    let colour = if picture.is_some() { "1 1 1" } else { "0.5 0.5 0.5" };
    let map = picture.map(|picture| format!("map_Kd {picture}\n")).unwrap_or_default();
    format!("# Orograph\nnewmtl terrain\nKa 0 0 0\nKd {colour}\nKs 0 0 0\nd 1\nillum 1\n{map}")
}

/// Writes a sound mesh.
///
/// # Errors
/// [`Error::Io`] from the stream, with `name`; [`Error::Cancelled`].
fn write(mesh: &Mesh, up: Up, material: &str, out: &mut impl Write, name: &str, job: &Job) -> Result<()> {
    let failed = |reason| Error::writing(name, reason);
    let turned = |vector: [f32; 3]| if up == Up::Y { y_up(vector) } else { vector };
    write!(out, "# Orograph, metres\nmtllib {material}\no terrain\nusemtl terrain\n").map_err(failed)?;
    // Writing to a vector cannot fail.
    let line = |bytes: &mut Vec<u8>, text: std::fmt::Arguments<'_>| drop(bytes.write_fmt(text));
    solid::stream(out, &mesh.vertices, name, job, |&vertex, bytes| {
        let [x, y, z] = turned(vertex);
        line(bytes, format_args!("v {x} {y} {z}\n"));
    })?;
    solid::stream(out, &mesh.uvs, name, job, |[u, v], bytes| line(bytes, format_args!("vt {u} {v}\n")))?;
    solid::stream(out, &mesh.normals, name, job, |&normal, bytes| {
        let [x, y, z] = turned(normal);
        line(bytes, format_args!("vn {x} {y} {z}\n"));
    })?;
    let (uvs, normals) = (!mesh.uvs.is_empty(), !mesh.normals.is_empty());
    solid::stream(out, &mesh.triangles, name, job, |corners, bytes| {
        bytes.push(b'f');
        for corner in corners.map(|corner| u64::from(corner) + 1) {
            match (uvs, normals) {
                (true, true) => line(bytes, format_args!(" {corner}/{corner}/{corner}")),
                (true, false) => line(bytes, format_args!(" {corner}/{corner}")),
                (false, true) => line(bytes, format_args!(" {corner}//{corner}")),
                (false, false) => line(bytes, format_args!(" {corner}")),
            }
        }
        bytes.push(b'\n');
    })
}

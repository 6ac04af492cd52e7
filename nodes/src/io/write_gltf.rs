//! Write glTF: a mesh with its texture in one binary file.
//!
//! Khronos Group (2021), *glTF 2.0 Specification*: a header, a chunk of JSON and a chunk of plain numbers.

use std::io::Write;

use orograph_core::{Mesh, prelude::*};
use serde_json::{Value as Json, json};

use super::{file, solid, write_texture};

/// Writes a mesh as binary glTF 2.0: one file, with its texture inside.
///
/// Blender, Unreal, Unity, Godot and browsers take it. As the format has it, y is up: the file's x is east, its y up and
/// its -z north, in metres.
#[derive(Params, Clone, Debug)]
pub struct WriteGltf {
    /// The file to write.
    #[param(default = "terrain.glb")]
    pub file: OutputPath,
}

/// Inputs of [`WriteGltf`].
#[derive(Inputs)]
pub struct WriteGltfIn<'a> {
    /// Mesh to write.
    pub mesh: &'a Mesh,
    /// Colours that lie over the terrain that the mesh was made from; grey without. Alpha is kept and does not count.
    pub texture: Option<&'a Texture>,
}

impl Node for WriteGltf {
    const ID: &'static str = "io.write_gltf";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    const DEFAULT_WRITER: bool = true;
    type Inputs<'a> = WriteGltfIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["glb"])
    }

    fn run(&self, inputs: WriteGltfIn<'_>, job: &Job) -> Result<()> {
        solid::check(inputs.mesh, inputs.texture, job)?;
        file::save(&self.file, job, |out| write(inputs.mesh, inputs.texture, out, &self.file.0, job))
    }
}

// Numbers that the specification names.
const MAGIC: u32 = 0x4654_6c67;
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY: u32 = 34962;
const ELEMENTS: u32 = 34963;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAPS: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33071;

/// Writes a sound mesh.
///
/// # Errors
/// [`Error::Invalid`] beyond the format's 4 GiB; [`Error::Io`] from the stream, with `name`; [`Error::Cancelled`].
pub(crate) fn write(
    mesh: &Mesh,
    texture: Option<&Texture>,
    out: &mut impl Write,
    name: &str,
    job: &Job,
) -> Result<()> {
    let mut picture = Vec::new();
    if let Some(texture) = texture {
        write_texture::write(texture, &mut picture, name, job)?;
    }
    let parts = Parts::of(mesh, picture.len());
    let mut json = serde_json::to_vec(&parts.json).map_err(|reason| Error::writing(name, reason))?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() as u64 + 8 + parts.bytes;
    let (Ok(length), Ok(binary)) = (u32::try_from(length), u32::try_from(parts.bytes)) else {
        return Err(Error::invalid(
            format!("the mesh takes {length} bytes, but glTF ends at 4 GiB"),
            "allow a larger error in mesh.triangulate, or make meshes of parts",
        ));
    };
    let failed = |reason| Error::writing(name, reason);
    let header = [MAGIC, 2, length, json.len() as u32, JSON_CHUNK].map(u32::to_le_bytes);
    out.write_all(header.as_flattened()).map_err(failed)?;
    out.write_all(&json).map_err(failed)?;
    out.write_all([binary, BINARY_CHUNK].map(u32::to_le_bytes).as_flattened()).map_err(failed)?;
    solid::stream(out, &mesh.triangles, name, job, |corners, bytes| {
        bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
    })?;
    let floats = |numbers: &[f32], bytes: &mut Vec<u8>| {
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    };
    solid::stream(out, &mesh.vertices, name, job, |place, bytes| floats(&y_up(*place), bytes))?;
    solid::stream(out, &mesh.normals, name, job, |normal, bytes| floats(&y_up(*normal), bytes))?;
    // Texture coordinates run down in this format.
    solid::stream(out, &mesh.uvs, name, job, |&[u, v], bytes| floats(&[u, 1.0 - v], bytes))?;
    out.write_all(&picture).map_err(failed)?;
    out.write_all(&[0; 3][..picture.len().next_multiple_of(4) - picture.len()]).map_err(failed)
}

/// x east, y north, z up turned into x east, y up, -z north.
pub(crate) fn y_up([x, y, z]: [f32; 3]) -> [f32; 3] {
    // Not -y, which makes a negative zero.
    [x, z, 0.0 - y]
}

/// What the JSON says, and the length of what follows it.
struct Parts {
    json: Json,
    bytes: u64,
}

impl Parts {
    fn of(mesh: &Mesh, picture: usize) -> Self {
        let (mut views, mut accessors) = (Vec::new(), Vec::new());
        let mut bytes = 0_u64;
        let mut view = |length: usize, target: Option<u32>| {
            let mut view = json!({"buffer": 0, "byteOffset": bytes, "byteLength": length});
            if let Some(target) = target {
                view["target"] = json!(target);
            }
            views.push(view);
            bytes += (length as u64).next_multiple_of(4);
            views.len() - 1
        };
        let at = view(mesh.triangles.len() * 12, Some(ELEMENTS));
        let count = mesh.triangles.len() * 3;
        accessors
            .push(json!({"bufferView": at, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"}));
        let mut attributes = json!({});
        let lists = [
            ("POSITION", mesh.vertices.len(), 12, "VEC3"),
            ("NORMAL", mesh.normals.len(), 12, "VEC3"),
            ("TEXCOORD_0", mesh.uvs.len(), 8, "VEC2"),
        ];
        for (attribute, count, size, shape) in lists {
            if count == 0 {
                continue;
            }
            let at = view(count * size, Some(ARRAY));
            let mut accessor =
                json!({"bufferView": at, "componentType": FLOAT, "count": count, "type": shape});
            if attribute == "POSITION" {
                let (least, most) = bounds(mesh);
                accessor["min"] = json!(least);
                accessor["max"] = json!(most);
            }
            attributes[attribute] = json!(accessors.len());
            accessors.push(accessor);
        }
        let mut surface = json!({"metallicFactor": 0.0, "roughnessFactor": 1.0});
        let mut json = json!({
            "asset": {"version": "2.0", "generator": "Orograph"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "terrain"}],
            "meshes": [{
                "name": "terrain",
                "primitives": [{"attributes": attributes, "indices": 0, "material": 0, "mode": 4}],
            }],
            "accessors": accessors,
        });
        if picture > 0 {
            let at = view(picture, None);
            surface["baseColorTexture"] = json!({"index": 0});
            json["textures"] = json!([{"sampler": 0, "source": 0}]);
            json["images"] = json!([{"bufferView": at, "mimeType": "image/png", "name": "terrain"}]);
            json["samplers"] = json!([{
                "magFilter": LINEAR, "minFilter": LINEAR_MIPMAPS, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE,
            }]);
        } else {
            surface["baseColorFactor"] = json!([0.5, 0.5, 0.5, 1.0]);
        }
        json["materials"] = json!([{"name": "terrain", "pbrMetallicRoughness": surface}]);
        json["bufferViews"] = json!(views);
        json["buffers"] = json!([{"byteLength": bytes}]);
        Self { json, bytes }
    }
}

/// The least and greatest coordinates, as they are written.
fn bounds(mesh: &Mesh) -> ([f32; 3], [f32; 3]) {
    let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    mesh.vertices.iter().map(|&place| y_up(place)).fold(start, |(least, most), place| {
        (
            [0, 1, 2].map(|axis| least[axis].min(place[axis])),
            [0, 1, 2].map(|axis| most[axis].max(place[axis])),
        )
    })
}

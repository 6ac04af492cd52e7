//! What is written for others, read by what others wrote: glTF by `gltf`, OBJ by `tobj`, PNG by `zune-png`, tiled
//! GeoTIFF by `tiff`. Headerless heights and OpenEXR are taken apart here by their formats' descriptions; the one
//! other reader of OpenEXR in Rust is the library that we write with.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod exporting;

use std::io::Cursor;

use exporting::{Folder, exr_channel, png};
use orograph_core::{Mesh, Rgba, Share, prelude::*};
use orograph_nodes::{
    io::{
        geotiff::{Compression, Layout},
        target::Target,
        write_exr::{WriteExr, WriteExrIn},
        write_geotiff::{WriteGeotiff, WriteGeotiffIn},
        write_geotiff_texture::{WriteGeotiffTexture, WriteGeotiffTextureIn},
        write_gltf::{WriteGltf, WriteGltfIn},
        write_mask::{WriteMask, WriteMaskIn},
        write_obj::{Up, WriteObj, WriteObjIn},
        write_png::{Depth, WritePng, WritePngIn},
        write_raw::{WriteRaw, WriteRawIn},
        write_texture::{WriteTexture, WriteTextureIn},
    },
    mask::{
        from_channel::{FromChannel, FromChannelIn},
        splat_map::{Channel, SplatMap, SplatMapIn},
    },
    mesh::triangulate::{Triangulate, TriangulateIn},
};
use zune_png::zune_core::result::DecodingResult;

/// A hill on oblong cells with a georeference and, where asked, a hole.
fn hill(rows: usize, cols: usize, hole: bool) -> Heightfield {
    let mut grid = Grid::new(rows, cols, CellSize { x: 4.0, y: 5.0 }).unwrap();
    let transform = [500_000.0, 4.0, 0.0, 4_000_000.0, 0.0, -5.0];
    grid.georef = Some(Georef { transform, crs: "EPSG:32632".into() }.into());
    let height = |row: usize, col: usize| {
        let (down, across) = (row as f64 / rows as f64 - 0.4, col as f64 / cols as f64 - 0.6);
        if hole && (row, col) == (rows / 2, cols / 2) {
            return f32::NAN;
        }
        (300.0 * libm::exp(-8.0 * (down * down + across * across)) + 20.0) as f32
    };
    let cells = (0..rows * cols).map(|i| height(i / cols, i % cols)).collect();
    Heightfield::new(grid, cells).unwrap()
}

/// Colours that tell the cell.
fn colours(terrain: &Heightfield) -> Texture {
    let cols = terrain.cols();
    let cells = (0..terrain.cells().len()).map(|i| [(i / cols) as u8, (i % cols) as u8, 77, 255]).collect();
    Texture::new(terrain.grid().clone(), cells).unwrap()
}

fn mesh(terrain: &Heightfield) -> Mesh {
    let node = Triangulate { max_error: 0.5, ..Triangulate::default() };
    node.run(TriangulateIn { terrain }, &Job::detached()).unwrap().mesh
}

#[test]
fn gltf_holds_the_mesh_y_up_with_its_texture() {
    let (folder, terrain) = (Folder::new(), hill(60, 50, true));
    let (mesh, texture) = (mesh(&terrain), colours(&terrain));
    assert!(mesh.vertices.len() > 50 && mesh.triangles.len() > 80);
    let inputs = WriteGltfIn { mesh: &mesh, texture: Some(&texture) };
    WriteGltf::default().run(inputs, &folder.job()).unwrap();
    let bytes = folder.read("terrain.glb");
    // The reader checks the document against the specification.
    let read = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = read.blob.as_deref().unwrap();
    let primitive = read.meshes().next().unwrap().primitives().next().unwrap();
    assert_eq!(read.nodes().count(), 1);
    let reader = primitive.reader(|_| Some(blob));
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
    let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices, mesh.triangles.as_flattened());
    let turned = |of: &[[f32; 3]]| of.iter().map(|&[x, y, z]| [x, z, 0.0 - y]).collect::<Vec<_>>();
    assert_eq!(positions, turned(&mesh.vertices));
    assert_eq!(normals, turned(&mesh.normals));
    let bounds = primitive.bounding_box();
    for axis in 0..3 {
        let along = || positions.iter().map(|position| position[axis]);
        assert_eq!(bounds.min[axis], along().fold(f32::INFINITY, f32::min));
        assert_eq!(bounds.max[axis], along().fold(f32::NEG_INFINITY, f32::max));
    }
    let height = terrain.range().unwrap();
    assert!(bounds.min[1] >= height.0 && bounds.max[1] <= height.1);
    let material = primitive.material().pbr_metallic_roughness();
    let image = material.base_color_texture().unwrap().texture().source();
    let gltf::image::Source::View { view, mime_type } = image.source() else { panic!("no view") };
    assert_eq!(mime_type, "image/png");
    let ((width, high), DecodingResult::U8(pixels)) = png(&blob[view.offset()..][..view.length()]) else {
        panic!("not 8 bits")
    };
    assert_eq!((width, high, pixels.len()), (50, 60, 50 * 60 * 3));
    for (position, [u, v]) in positions.iter().zip(uvs) {
        // The pixel that a vertex takes its colour from, from the upper left, is that of its cell.
        let (col, row) = ((u * 50.0 - 0.5).round() as usize, (v * 60.0 - 0.5).round() as usize);
        assert!((position[0] - (col as f32 - 24.5) * 4.0).abs() < 1e-3);
        assert!((position[2] - (row as f32 - 29.5) * 5.0).abs() < 1e-3);
        assert!((position[1] - terrain.at(row, col)).abs() < 1e-3);
        assert_eq!(pixels[(row * 50 + col) * 3..][..3], [row as u8, col as u8, 77]);
    }
    // Without a texture it is as sound, and grey.
    WriteGltf::default().run(WriteGltfIn { mesh: &mesh, texture: None }, &folder.job()).unwrap();
    let read = gltf::Gltf::from_slice(&folder.read("terrain.glb")).unwrap();
    assert!(read.materials().next().unwrap().pbr_metallic_roughness().base_color_texture().is_none());
}

#[test]
fn obj_holds_the_mesh_with_material_and_texture_beside_it() {
    let (folder, terrain) = (Folder::new(), hill(40, 50, false));
    let (mesh, texture) = (mesh(&terrain), colours(&terrain));
    for up in [Up::Y, Up::Z] {
        let node = WriteObj { file: OutputPath("maps/north hill.obj".into()), up };
        node.run(WriteObjIn { mesh: &mesh, texture: Some(&texture) }, &folder.job()).unwrap();
        let text = folder.read("maps/north hill.obj");
        let options = tobj::LoadOptions { triangulate: false, single_index: true, ..Default::default() };
        let (models, materials) = tobj::load_obj_buf(&mut Cursor::new(text), &options, |file| {
            assert_eq!(file.to_str(), Some("north hill.mtl"));
            tobj::load_mtl_buf(&mut Cursor::new(folder.read("maps/north hill.mtl")))
        })
        .unwrap();
        let read = &models[0].mesh;
        assert_eq!((models.len(), read.material_id), (1, Some(0)));
        // The reader numbers vertices as triangles come to them.
        assert_eq!(read.indices.len(), mesh.triangles.len() * 3);
        let turned = |[x, y, z]: [f32; 3]| if up == Up::Y { [x, z, 0.0 - y] } else { [x, y, z] };
        for (&found, &corner) in read.indices.iter().zip(mesh.triangles.as_flattened()) {
            let (found, corner) = (found as usize, corner as usize);
            assert_eq!(read.positions[found * 3..][..3], turned(mesh.vertices[corner]));
            assert_eq!(read.normals[found * 3..][..3], turned(mesh.normals[corner]));
            assert_eq!(read.texcoords[found * 2..][..2], mesh.uvs[corner]);
        }
        let material = &materials.unwrap()[0];
        assert_eq!(material.diffuse_texture.as_deref(), Some("north hill_texture.png"));
    }
    let ((width, height), DecodingResult::U8(pixels)) = png(&folder.read("maps/north hill_texture.png"))
    else {
        panic!("not 8 bits")
    };
    assert_eq!((width, height, &pixels[50 * 3..][..3]), (50, 40, &[1, 0, 77][..]));
}

#[test]
fn meshes_that_break_their_rules_are_refused_and_leave_no_file() {
    let folder = Folder::new();
    let texture = colours(&hill(3, 3, false));
    let sound = Mesh {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let broken = [
        Mesh::default(),
        Mesh { triangles: vec![[0, 1, 3]], ..sound.clone() },
        Mesh { normals: vec![[0.0, 0.0, 1.0]], ..sound.clone() },
        Mesh { vertices: vec![[f32::NAN; 3]; 3], ..sound.clone() },
    ];
    for mesh in &broken {
        let error = WriteGltf::default().run(WriteGltfIn { mesh, texture: None }, &folder.job()).unwrap_err();
        assert!(error.hint().is_some(), "{error}");
        assert!(WriteObj::default().run(WriteObjIn { mesh, texture: None }, &folder.job()).is_err());
    }
    let inputs = WriteObjIn { mesh: &sound, texture: Some(&texture) };
    let error = WriteObj::default().run(inputs, &folder.job()).unwrap_err();
    assert!(error.to_string().contains("texture coordinates"), "{error}");
    assert_eq!(folder.names(), [""; 0]);
    // Neither normals nor texture coordinates are needed.
    let inputs = WriteObjIn { mesh: &sound, texture: None };
    WriteObj::default().run(inputs, &folder.job()).unwrap();
    WriteGltf::default().run(WriteGltfIn { mesh: &sound, texture: None }, &folder.job()).unwrap();
    gltf::Gltf::from_slice(&folder.read("terrain.glb")).unwrap();
    assert_eq!(folder.names(), ["terrain.glb", "terrain.mtl", "terrain.obj"]);
}

/// The heights that Unreal makes of levels, from the scale and location that the run told.
fn unreal_height(told: &str, level: u16) -> f64 {
    let numbers: Vec<f64> = told.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    let [_, _, scale, location] = numbers[..] else { panic!("{told}") };
    ((f64::from(level) - 32768.0) / 128.0 * scale + location) / 100.0
}

#[test]
fn unreal_s_levels_are_the_heights_that_went_in() {
    let (folder, terrain) = (Folder::new(), hill(127, 253, false));
    let node = WritePng { target: Target::Unreal, ..WritePng::default() };
    node.run(WritePngIn { terrain: &terrain }, &folder.job()).unwrap();
    let told = folder.told("Unreal");
    assert!(told.contains("scale to 400, 500, "), "{told}");
    let ((width, height), DecodingResult::U16(levels)) = png(&folder.read("terrain.png")) else {
        panic!("not 16 bits")
    };
    assert_eq!((width, height), (253, 127));
    let node = WriteRaw { target: Target::Unreal, ..WriteRaw::default() };
    node.run(WriteRawIn { terrain: &terrain }, &folder.job()).unwrap();
    assert_eq!(folder.told("Unreal"), told);
    let raw = folder.read("terrain.r16");
    assert_eq!(raw.len(), 127 * 253 * 2);
    let step = f64::from(terrain.range().unwrap().1 - terrain.range().unwrap().0) / 65535.0;
    for (i, (&level, &wanted)) in levels.iter().zip(terrain.cells()).enumerate() {
        assert_eq!(level, u16::from_le_bytes([raw[2 * i], raw[2 * i + 1]]));
        let found = unreal_height(&told, level);
        assert!((found - f64::from(wanted)).abs() < 0.51 * step + 1e-4, "{found} is not {wanted}");
    }
    let wrong = hill(130, 130, false);
    let error = node.run(WriteRawIn { terrain: &wrong }, &folder.job()).unwrap_err();
    assert!(error.hint().unwrap().contains("128 or 134"), "{error}");
    let shallow = WritePng { target: Target::Unreal, depth: Depth::Eight, ..WritePng::default() };
    assert!(shallow.check().is_err());
}

#[test]
fn unity_s_file_begins_in_the_south() {
    let (folder, terrain) = (Folder::new(), hill(33, 33, false));
    let file = OutputPath("unity.raw".into());
    let node = WriteRaw { file, target: Target::Unity, south_first: true, ..WriteRaw::default() };
    node.run(WriteRawIn { terrain: &terrain }, &folder.job()).unwrap();
    let told = folder.told("Unity");
    assert!(told.contains("resolution 33, width 128, length 160"), "{told}");
    let raw = folder.read("unity.raw");
    let (low, high) = terrain.range().unwrap();
    for (i, pair) in raw.as_chunks::<2>().0.iter().enumerate() {
        let found = f32::from(u16::from_le_bytes(*pair)) / 65535.0 * (high - low) + low;
        assert!((found - terrain.at(32 - i / 33, i % 33)).abs() < 0.01);
    }
}

#[test]
fn splat_maps_keep_their_weights_through_files() {
    let (folder, terrain) = (Folder::new(), hill(64, 64, false));
    let job = &folder.job();
    let mask = |k: u64| -> Mask {
        let share = |i: i64| orograph_core::unit(orograph_core::key(3, k, i, 0)) as f32;
        let cells = (0..terrain.cells().len() as i64).map(share).collect();
        Raster::<Share>::new(terrain.grid().clone(), cells).unwrap()
    };
    let masks = [mask(0), mask(1), mask(2)];
    let inputs = SplatMapIn { masks: masks.iter().collect() };
    let splat: Raster<Rgba> =
        SplatMap { base: Channel::Alpha, ..SplatMap::default() }.run(inputs, job).unwrap().splat;
    WriteTexture::default().run(WriteTextureIn { texture: &splat }, job).unwrap();
    let (_, DecodingResult::U8(pixels)) = png(&folder.read("texture.png")) else { panic!("not 8 bits") };
    // Nothing is multiplied with alpha, not even where it is 0.
    assert_eq!(pixels, splat.cells().as_flattened());
    assert!(
        pixels
            .as_chunks::<4>()
            .0
            .iter()
            .all(|weights| weights.iter().map(|&w| u32::from(w)).sum::<u32>() == 255)
    );
    // A weight map for each layer, as Unreal takes them, has the same levels.
    for (channel, which) in [(Channel::Red, 0), (Channel::Alpha, 3)] {
        let mask = FromChannel { channel }.run(FromChannelIn { texture: &splat }, job).unwrap().mask;
        let node = WriteMask { depth: Depth::Eight, ..WriteMask::default() };
        node.run(WriteMaskIn { mask: &mask }, job).unwrap();
        let (_, DecodingResult::U8(levels)) = png(&folder.read("mask.png")) else { panic!("not 8 bits") };
        assert!(levels.iter().zip(splat.cells()).all(|(&level, weights)| level == weights[which]));
        // 63 quads and one vertex are a landscape; half of that is none.
        let node = WriteMask { target: Target::Unreal, ..node };
        node.run(WriteMaskIn { mask: &mask }, job).unwrap();
        let part = mask.crop(0, 0, 33, 33, job).unwrap();
        assert!(node.run(WriteMaskIn { mask: &part }, job).is_err());
    }
}

#[test]
fn geotiff_comes_in_tiles_that_another_library_reads() {
    let (folder, terrain) = (Folder::new(), hill(300, 520, true));
    for layout in [Layout::Tiles, Layout::Strips] {
        let node = WriteGeotiff { layout, ..WriteGeotiff::default() };
        node.run(WriteGeotiffIn { terrain: &terrain }, &folder.job()).unwrap();
        let mut reader = tiff::decoder::Decoder::new(Cursor::new(folder.read("terrain.tif"))).unwrap();
        assert_eq!(reader.dimensions().unwrap(), (520, 300));
        if layout == Layout::Tiles {
            assert_eq!((reader.chunk_dimensions(), reader.tile_count().unwrap()), ((256, 256), 6));
        } else {
            assert!(reader.strip_count().unwrap() > 1);
        }
        let scale = reader.get_tag_f64_vec(tiff::tags::Tag::ModelPixelScaleTag).unwrap();
        assert_eq!(scale[..2], [4.0, 5.0]);
        let tie = reader.get_tag_f64_vec(tiff::tags::Tag::ModelTiepointTag).unwrap();
        assert_eq!(tie[3..5], [500_000.0, 4_000_000.0]);
        assert_eq!(reader.get_tag_ascii_string(tiff::tags::Tag::GdalNodata).unwrap().trim(), "-32768");
        let tiff::decoder::DecodingResult::F32(cells) = reader.read_image().unwrap() else {
            panic!("not floating point")
        };
        for (found, &wanted) in cells.iter().zip(terrain.cells()) {
            assert_eq!(*found, if wanted.is_nan() { -32768.0 } else { wanted });
        }
    }
}

#[test]
fn geotiff_holds_every_colour_with_and_without_alpha() {
    let (folder, terrain) = (Folder::new(), hill(300, 520, false));
    let mut texture = colours(&terrain);
    for (index, colour) in texture.cells_mut().iter_mut().enumerate() {
        colour[3] = (index % 251) as u8;
    }
    for (alpha, compression, layout) in [
        (false, Compression::Deflate, Layout::Tiles),
        (true, Compression::Deflate, Layout::Strips),
        (true, Compression::Lzw, Layout::Tiles),
        (false, Compression::None, Layout::Strips),
    ] {
        let node = WriteGeotiffTexture { alpha, compression, layout, ..WriteGeotiffTexture::default() };
        node.run(WriteGeotiffTextureIn { texture: &texture }, &folder.job()).unwrap();
        let mut reader = tiff::decoder::Decoder::new(Cursor::new(folder.read("texture.tif"))).unwrap();
        let kind = if alpha { tiff::ColorType::RGBA(8) } else { tiff::ColorType::RGB(8) };
        assert_eq!((reader.dimensions().unwrap(), reader.colortype().unwrap()), ((520, 300), kind));
        let tie = reader.get_tag_f64_vec(tiff::tags::Tag::ModelTiepointTag).unwrap();
        assert_eq!(tie[3..5], [500_000.0, 4_000_000.0]);
        let tiff::decoder::DecodingResult::U8(samples) = reader.read_image().unwrap() else {
            panic!("not bytes")
        };
        let of_a_cell = if alpha { 4 } else { 3 };
        assert_eq!(samples.len(), of_a_cell * texture.cells().len());
        for (found, wanted) in samples.chunks(of_a_cell).zip(texture.cells()) {
            assert_eq!(found, &wanted[..of_a_cell]);
        }
    }
}

#[test]
fn exr_holds_every_height_as_it_is() {
    let (folder, terrain) = (Folder::new(), hill(37, 50, true));
    WriteExr::default().run(WriteExrIn { terrain: &terrain }, &folder.job()).unwrap();
    let (width, heights) = exr_channel(&folder.read("terrain.exr"));
    assert_eq!((width, heights.len()), (50, 37 * 50));
    for (found, wanted) in heights.iter().zip(terrain.cells()) {
        assert!(found == wanted || found.is_nan() && wanted.is_nan(), "{found} is not {wanted}");
    }
}

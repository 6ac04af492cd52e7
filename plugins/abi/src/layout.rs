//! Every field's place, as it was in ABI 1.0. A change here is another major version.

use std::mem::{align_of, offset_of, size_of};

use crate::*;

macro_rules! laid_out {
    ($($name:ident, $size:literal, $align:literal: $($field:ident $place:literal),*;)*) => {$(
        assert_eq!((size_of::<$name>(), align_of::<$name>()), ($size, $align), stringify!($name));
        $(assert_eq!(offset_of!($name, $field), $place, concat!(stringify!($name), ".", stringify!($field)));)*
    )*};
}

/// Computed by hand from the rules of C on a machine of 64 bits.
#[test]
#[cfg(target_pointer_width = "64")]
fn every_field_stays_where_it_was() {
    laid_out! {
        OrographText, 16, 8: data 0, len 8;
        OrographGrid, 136, 8: size 0, georeferenced 4, rows 8, cols 16, row0 24, col0 32, cell_x 40, cell_y 48, origin_x 56, origin_y 64, transform 72, crs 120;
        OrographRaster, 24, 8: size 0, reserved 4, grid 8, cells 16;
        OrographFeaturePoint, 24, 8: row 0, col 8, height 16, kind 20;
        OrographLine, 40, 8: from 0, to 4, vertex_count 8, vertices 16, profile_count 24, profiles 32;
        OrographFeatures, 88, 8: size 0, kind 4, grid 8, point_count 16, points 24, line_count 32, lines 40, ring_count 48, rings 56, scale 64, profile_step 72, profile_len 80, reserved 84;
        OrographPoints, 40, 8: size 0, reserved 4, count 8, x 16, y 24, heights 32;
        OrographPatch, 72, 8: exemplar 0, window 4, mirrored 8, reserved 12, source_center 16, target_center 32, offset 48, control_count 56, controls 64;
        OrographPlacement, 80, 8: size 0, reserved 4, grid 8, scale_count 16, scales 24, patch_count 32, patches 40, labels 48, sources 56, seam_count 64, seams 72;
        OrographColumn, 48, 8: name 0, unit 16, numbers 32, texts 40;
        OrographTable, 32, 8: size 0, reserved 4, column_count 8, row_count 16, columns 24;
        OrographMesh, 56, 8: size 0, reserved 4, vertex_count 8, vertices 16, normals 24, uvs 32, triangle_count 40, triangles 48;
        OrographData, 16, 8: raster 0, features 0, points 0, placement 0, table 0, mesh 0, number 0, integer 0, boolean 0, text 0;
        OrographValue, 24, 8: kind 0, reserved 4, data 8;
        OrographInput, 16, 8: count 0, values 8;
        OrographCurve, 16, 8: count 0, points 8;
        OrographPolyline, 16, 8: count 0, vertices 8;
        OrographLines, 16, 8: count 0, lines 8;
        OrographSetting, 16, 8: number 0, integer 0, boolean 0, text 0, curve 0, lines 0;
        OrographParam, 24, 8: kind 0, reserved 4, value 8;
        OrographPlugin, 40, 8: size 0, abi_major 4, abi_minor 8, reserved 12, describe 16, run 24, extension 32;
        OrographJob, 80, 8: size 0, node 4, id 8, host 16, param_count 24, params 32, input_count 40, inputs 48, seed 56, resolution 64, reserved 68, memory_limit 72;
        OrographHost, 64, 8: size 0, abi_major 4, abi_minor 8, reserved 12, cancelled 16, progress 24, log 32, fail 40, output 48, extension 56;
        OrographThreads, 24, 8: size 0, reserved 4, count 8, parallel_for 16;
        OrographScratch, 24, 8: size 0, reserved 4, allocate 8, free 16;
        OrographFiles, 16, 8: size 0, reserved 4, input_path 8;
        OrographReply, 16, 8: context 0, put 8;
        OrographSettings, 40, 8: size 0, reserved 4, check 8, halo 16, cost 24, upgrade 32;
    }
}

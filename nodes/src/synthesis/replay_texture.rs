//! Texture replay: pictures of the exemplar, carried to where a synthesis put its ground.
//!
//! Colours jump at seams, as sources far apart have other light and other growth. The jump is spread as that of heights
//! is (Pérez, P., Gangnet, M. and Blake, A. (2003), "Poisson image editing", ACM Transactions on Graphics 22 (3)): the
//! colours of least change, their steps kept inside patches and none wanted across seams, held to those before.

use orograph_core::Placement;
use orograph_core::prelude::*;

use super::{
    poisson::natural,
    replay::{Origins, nearest},
};

/// Carries a picture that lies over the exemplar, such as an aerial photograph, to where synthesis put its ground.
///
/// Each pixel is the nearest one of the source. Cells that came from no exemplar are transparent.
#[derive(Params, Clone, Debug)]
pub struct ReplayTexture {
    /// How far the change of colour at a seam is spread to either side; 0 keeps every pixel as it is.
    #[param(default = 0, range = 0.0..=100_000.0, slider = 0.0..=200.0, unit = "cells")]
    pub blend: f64,
}

/// Inputs of [`ReplayTexture`].
#[derive(Inputs)]
pub struct ReplayTextureIn<'a> {
    /// Which patch went where.
    pub placement: &'a Placement,
    /// The picture over each exemplar, in the order in which synthesis had them.
    pub textures: Vec<&'a Texture>,
}

/// Outputs of [`ReplayTexture`].
#[derive(Outputs)]
pub struct ReplayTextureOut {
    /// The picture over the synthesised terrain.
    pub texture: Texture,
}

impl Node for ReplayTexture {
    const ID: &'static str = "synthesis.replay_texture";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ReplayTextureIn<'a>;
    type Outputs = ReplayTextureOut;

    fn run(&self, inputs: ReplayTextureIn<'_>, job: &Job) -> Result<ReplayTextureOut> {
        let origins = Origins::new(inputs.placement, inputs.textures.len())?;
        let mut texture = Texture::build(inputs.placement.grid.clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                if let Some((exemplar, at, _)) = origins.at(row, col) {
                    *out = nearest(inputs.textures[exemplar], at).unwrap_or_default();
                }
            }
            Ok(())
        })?;
        if self.blend > 0.0 {
            blend(&mut texture, inputs.placement, self.blend, job)?;
        }
        Ok(ReplayTextureOut { texture })
    }
}

/// Spreads the jumps of colour at the seams of `placement` over about `reach` cells.
fn blend(texture: &mut Texture, placement: &Placement, reach: f64, job: &Job) -> Result<()> {
    let (cols, n) = (texture.cols(), texture.cells().len());
    job.admit(n as u64 * 16, || format!("the steps of {n} pixels"))?;
    for channel in 0..3 {
        let mut right = vec![0.0; n];
        let pixels = texture.cells();
        for i in 0..n {
            if i % cols == 0 {
                job.check()?;
            }
            for j in [((i + 1) % cols != 0).then_some(i + 1), Some(i + cols)].into_iter().flatten() {
                let is_seam = |j: &usize| {
                    let seen = pixels[i][3] > 0 && pixels.get(*j).is_some_and(|pixel| pixel[3] > 0);
                    seen && placement.labels[i] != placement.labels[*j]
                };
                if let Some(j) = Some(j).filter(is_seam) {
                    let jump = f64::from(pixels[j][channel]) - f64::from(pixels[i][channel]);
                    right[i] += jump;
                    right[j] -= jump;
                }
            }
        }
        let change = natural::solve(cols, &right, 1.0 / (reach * reach), job)?;
        for (pixel, change) in texture.cells_mut().iter_mut().zip(change).filter(|(pixel, _)| pixel[3] > 0) {
            pixel[channel] = (f64::from(pixel[channel]) + change).round().clamp(0.0, 255.0) as u8;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use orograph_core::{Patch, key, unit};

    use super::*;
    use crate::{
        synthesis::replay::{Replay, ReplayIn},
        test_fields::field,
        transform::sample::Interpolation,
    };

    fn patch(exemplar: u32, offset: f64) -> Patch {
        let (source_center, target_center) = ([0.0; 2], [0.0; 2]);
        Patch {
            exemplar,
            source_center,
            target_center,
            size: 1,
            mirrored: false,
            controls: Vec::new(),
            offset,
        }
    }

    /// Colours that no two cells share.
    fn picture(rows: usize, cols: usize, blue: u8) -> Texture {
        let grid = Grid::new(rows, cols, CellSize::square(10.0)).unwrap();
        Texture::new(grid, (0..rows * cols).map(|i| [i as u8, (i >> 8) as u8, blue, 200]).collect()).unwrap()
    }

    fn carried(placement: &Placement, textures: Vec<&Texture>) -> Texture {
        ReplayTexture::default()
            .run(ReplayTextureIn { placement, textures }, &Job::detached())
            .unwrap()
            .texture
    }

    #[test]
    fn ground_that_stays_in_place_keeps_its_picture_to_the_bit() {
        let source = picture(37, 29, 7);
        let placement = Placement {
            grid: source.grid().clone(),
            scales: vec![[1.0; 2]],
            patches: vec![patch(0, 55.0)],
            labels: vec![1; 37 * 29],
            sources: (0..37 * 29).map(|i| [(i / 29) as f32, (i % 29) as f32]).collect(),
            seams: Vec::new(),
        };
        assert_eq!(carried(&placement, vec![&source]).cells(), source.cells());
    }

    #[test]
    fn each_cell_shows_the_pixel_that_it_came_from() {
        // Two exemplars, the second of which was made twice as fine across and half as fine down.
        let textures = [picture(30, 40, 0), picture(24, 18, 1)];
        let scales = vec![[1.0, 1.0], [0.5, 2.0]];
        let grid = picture(50, 45, 9).grid().clone();
        let draw = |stream: u64, i: usize| unit(key(6, stream, i as i64, 0));
        // Here and there a source lies off its exemplar.
        let source = |i: usize| [draw(1, i) as f32 * 33.0 - 1.0, draw(2, i) as f32 * 42.0 - 1.0];
        let placement = Placement {
            grid: grid.clone(),
            scales: scales.clone(),
            patches: vec![patch(0, 10.0), patch(1, -20.0), patch(0, 0.0)],
            labels: (0..grid.len()).map(|i| (draw(3, i) * 4.0) as u32).collect(),
            sources: (0..grid.len()).map(source).collect(),
            seams: Vec::new(),
        };
        let heights = [(30, 40, 0.0), (24, 18, 5000.0)]
            .map(|(rows, cols, base)| field(rows, cols, |row, col| base + (row * cols + col) as f64));
        let node = Replay { interpolation: Interpolation::Nearest, lift: true };
        let layers = node
            .run(ReplayIn { placement: &placement, layers: heights.iter().collect() }, &Job::detached())
            .unwrap()
            .layer;
        let out = carried(&placement, textures.iter().collect());
        let mut n_found = 0;
        for i in 0..grid.len() {
            let found = (placement.labels[i] as usize).checked_sub(1).and_then(|label| {
                let exemplar = placement.patches[label].exemplar as usize;
                let [row, col] = [0, 1].map(|axis| {
                    // The cell whose share of the scaled side the place lies in.
                    ((f64::from(placement.sources[i][axis]) + 0.5) / scales[exemplar][axis]).floor()
                });
                let (rows, cols) = textures[exemplar].grid().size();
                let inside = row >= 0.0 && col >= 0.0 && row < rows as f64 && col < cols as f64;
                inside.then_some((exemplar, row as usize, col as usize, placement.patches[label].offset))
            });
            match found {
                Some((exemplar, row, col, offset)) => {
                    n_found += 1;
                    assert_eq!(out.cells()[i], textures[exemplar].at(row, col));
                    assert_eq!(layers.cells()[i], heights[exemplar].at(row, col) + offset as f32);
                }
                None => {
                    assert_eq!(out.cells()[i], [0; 4]);
                    assert!(layers.cells()[i].is_nan());
                }
            }
        }
        assert!(n_found > 900);
    }

    #[test]
    fn the_jump_at_a_seam_is_spread_as_by_a_held_membrane() {
        // One row: forty pixels of 60 beside forty of 160, from two places of one exemplar.
        let source = {
            let grid = Grid::new(1, 2, CellSize::square(10.0)).unwrap();
            Texture::new(grid, vec![[60, 9, 9, 255], [160, 9, 9, 255]]).unwrap()
        };
        let side = |i: usize| usize::from(i >= 40);
        let placement = Placement {
            grid: Grid::new(1, 80, CellSize::square(10.0)).unwrap(),
            scales: vec![[1.0; 2]],
            patches: vec![patch(0, 0.0), patch(0, 0.0)],
            labels: (0..80).map(|i| side(i) as u32 + 1).collect(),
            sources: (0..80).map(|i| [0.0, side(i) as f32]).collect(),
            seams: Vec::new(),
        };
        let reach = 6.0;
        let node = ReplayTexture { blend: reach };
        let inputs = ReplayTextureIn { placement: &placement, textures: vec![&source] };
        let out = node.run(inputs, &Job::detached()).unwrap().texture;
        // From the seam on a geometric series, whose ratio solves r + 1/r = 2 + 1/reach²; at the seam steps balance.
        let hold = 1.0 / (reach * reach);
        let ratio = 1.0 + hold / 2.0 - (hold + hold * hold / 4.0_f64).sqrt();
        let start = 100.0 / (3.0 - ratio + hold);
        for i in 0..80 {
            let away = if i < 40 { 39 - i } else { i - 40 };
            let expected = start * libm::pow(ratio, away as f64);
            let truth = if i < 40 { 60.0 + expected } else { 160.0 - expected };
            assert!((f64::from(out.at(0, i)[0]) - truth).abs() <= 1.0, "{i}: {:?} {truth}", out.at(0, i));
            assert_eq!(out.at(0, i)[1..], [9, 9, 255]);
        }
    }

    #[test]
    fn a_picture_for_each_exemplar_is_wanted() {
        let source = picture(3, 3, 0);
        let placement = Placement {
            grid: source.grid().clone(),
            scales: Vec::new(),
            patches: vec![patch(1, 0.0)],
            labels: vec![1; 9],
            sources: vec![[1.0; 2]; 9],
            seams: Vec::new(),
        };
        let node = ReplayTexture::default();
        let inputs = ReplayTextureIn { placement: &placement, textures: vec![&source] };
        assert!(node.run(inputs, &Job::detached()).is_err());
    }
}

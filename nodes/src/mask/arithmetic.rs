//! Mask arithmetic: logic on shares.
use orograph_core::prelude::*;

/// How two masks become one. On masks of 0 and 1 these are the operations of logic.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Where both are set: the smaller share.
    Intersect,
    /// Where either is set: the larger share.
    Unite,
    /// Where the first is set and the second is not.
    Subtract,
    /// Where exactly one is set: the difference of the shares.
    Differ,
    /// The product of the shares.
    Multiply,
    /// Where the first is not set; the second does not count.
    Invert,
}

/// Joins two masks, or inverts one.
#[derive(Params, Clone, Debug)]
pub struct Arithmetic {
    /// How the masks become one.
    #[param(default = Operation::Intersect)]
    pub operation: Operation,
}

/// Inputs of [`Arithmetic`].
#[derive(Inputs)]
pub struct ArithmeticIn<'a> {
    /// First mask; the result lies where it lies.
    pub a: &'a Mask,
    /// Second mask, on a grid of the same size; only inverting does without.
    pub b: Option<&'a Mask>,
}

/// Outputs of [`Arithmetic`].
#[derive(Outputs)]
pub struct ArithmeticOut {
    /// The result.
    pub mask: Mask,
}

impl Node for Arithmetic {
    const ID: &'static str = "mask.arithmetic";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = ArithmeticIn<'a>;
    type Outputs = ArithmeticOut;

    fn run(&self, inputs: ArithmeticIn<'_>, job: &Job) -> Result<ArithmeticOut> {
        let (a, b) = (inputs.a, inputs.b);
        let b = match self.operation {
            Operation::Invert => a,
            _ => b.ok_or_else(|| {
                Error::invalid("this operation takes two masks, but `b` is not connected", "connect `b`")
            })?,
        };
        let mask = match self.operation {
            Operation::Intersect => a.map_with(b, job, |a, b| a.min(b)),
            Operation::Unite => a.map_with(b, job, |a, b| a.max(b)),
            Operation::Subtract => a.map_with(b, job, |a, b| a.min(1.0 - b)),
            Operation::Differ => a.map_with(b, job, |a, b| (a - b).abs()),
            Operation::Multiply => a.map_with(b, job, |a, b| a * b),
            Operation::Invert => a.map(job, |share| 1.0 - share),
        }?;
        Ok(ArithmeticOut { mask })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    fn mask(cells: &[f32]) -> Mask {
        Mask::new(row(cells).grid().clone(), cells.to_vec()).unwrap()
    }

    #[test]
    fn operations_are_those_of_logic() {
        let (a, b) = (mask(&[0.0, 0.0, 1.0, 1.0]), mask(&[0.0, 1.0, 0.0, 1.0]));
        for (operation, expected) in [
            (Operation::Intersect, [0.0, 0.0, 0.0, 1.0]),
            (Operation::Unite, [0.0, 1.0, 1.0, 1.0]),
            (Operation::Subtract, [0.0, 0.0, 1.0, 0.0]),
            (Operation::Differ, [0.0, 1.0, 1.0, 0.0]),
            (Operation::Multiply, [0.0, 0.0, 0.0, 1.0]),
            (Operation::Invert, [1.0, 1.0, 0.0, 0.0]),
        ] {
            let inputs = ArithmeticIn { a: &a, b: Some(&b) };
            let out = Arithmetic { operation }.run(inputs, &Job::detached()).unwrap().mask;
            assert_eq!(out.cells(), expected, "{operation:?}");
        }
    }

    #[test]
    fn a_missing_second_mask_is_named() {
        let a = mask(&[1.0]);
        let run = |operation| Arithmetic { operation }.run(ArithmeticIn { a: &a, b: None }, &Job::detached());
        assert!(run(Operation::Unite).is_err());
        assert!(run(Operation::Invert).is_ok());
    }
}

//! Colours and gradients, as settings have them and as graphs write them.

use std::{borrow::Cow, fmt, str::FromStr};

use crate::{Error, ParamField, ParamKind, ParamValue};

/// A colour: red, green, blue, alpha. Written `#rrggbb`, or `#rrggbbaa` where it is translucent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub [u8; 4]);

impl Colour {
    /// The opaque colour `0xrrggbb`.
    #[must_use]
    pub const fn rgb(hex: u32) -> Self {
        let [_, r, g, b] = hex.to_be_bytes();
        Self([r, g, b, 255])
    }
}

impl FromStr for Colour {
    type Err = Error;

    /// # Errors
    /// [`Error::Invalid`] for anything but `#rrggbb` and `#rrggbbaa`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || {
            Error::invalid(
                format!("`{}` is no colour", text.escape_debug()),
                "write it as `#rrggbb` or `#rrggbbaa`, for example `#c83c28`",
            )
        };
        let digits = text.strip_prefix('#').ok_or_else(wrong)?;
        if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(wrong());
        }
        let mut colour = [255; 4];
        for (i, part) in colour.iter_mut().enumerate().take(digits.len() / 2) {
            *part = u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).map_err(|_| wrong())?;
        }
        Ok(Self(colour))
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b, a] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")?;
        if a < 255 { write!(f, "{a:02x}") } else { Ok(()) }
    }
}

/// Most stops of a gradient.
const STOPS: usize = 256;

/// Colours at places from 0 to 1, linear in between and constant beyond. Written `0 #203040, 0.5 #c0b080, 1 #ffffff`;
/// a gradient without stops is the empty text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient(Cow<'static, [(f64, Colour)]>);

impl Gradient {
    /// The gradient through these stops.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a place does not lie from 0 to 1 or above the one before, or they are too many.
    pub fn new(stops: Vec<(f64, Colour)>) -> Result<Self, Error> {
        if stops.len() > STOPS {
            return Err(Error::invalid(
                format!("a gradient of {} stops", stops.len()),
                format!("give it {STOPS} at most"),
            ));
        }
        if let Some((place, _)) = stops.iter().find(|(place, _)| !(0.0..=1.0).contains(place)) {
            return Err(Error::invalid(
                format!("a stop at {place}"),
                "stops lie from 0, the first colour, to 1, the last",
            ));
        }
        if let Some(pair) = stops.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
            return Err(Error::invalid(
                format!("the stop at {} does not lie above the one before, at {}", pair[1].0, pair[0].0),
                "sort the stops and give each its own place",
            ));
        }
        Ok(Self(Cow::Owned(stops)))
    }

    /// The gradient through stops that are known to be in order.
    #[must_use]
    pub const fn of(stops: &'static [(f64, Colour)]) -> Self {
        Self(Cow::Borrowed(stops))
    }

    /// Its stops, in order.
    #[must_use]
    pub fn stops(&self) -> &[(f64, Colour)] {
        &self.0
    }

    /// The colour at `share`; none of a gradient without stops. NaN has the first colour.
    #[must_use]
    pub fn at(&self, share: f64) -> Option<Colour> {
        let stops = &self.0;
        let after = stops.partition_point(|stop| stop.0 <= share);
        match (after.checked_sub(1).and_then(|before| stops.get(before)), stops.get(after)) {
            (Some((low, from)), Some((high, to))) => {
                let t = (share - low) / (high - low);
                let mix = |i: usize| {
                    let (from, to) = (f64::from(from.0[i]), f64::from(to.0[i]));
                    (from + (to - from) * t + 0.5) as u8
                };
                Some(Colour([mix(0), mix(1), mix(2), mix(3)]))
            }
            (Some((_, end)), None) | (None, Some((_, end))) => Some(*end),
            (None, None) => None,
        }
    }
}

impl FromStr for Gradient {
    type Err = Error;

    /// # Errors
    /// [`Error::Invalid`] with the stop that is wrong.
    fn from_str(text: &str) -> Result<Self, Error> {
        if text.trim().is_empty() {
            return Ok(Self::default());
        }
        let stop = |text: &str| {
            let wrong = || {
                Error::invalid(
                    format!("`{}` is no stop of a gradient", text.trim().escape_debug()),
                    "write stops as `0 #203040, 0.5 #c0b080, 1 #ffffff`",
                )
            };
            let (place, colour) = text.trim().split_once(char::is_whitespace).ok_or_else(wrong)?;
            let place: f64 = place.parse().map_err(|_| wrong())?;
            Ok((place, colour.trim().parse()?))
        };
        Self::new(text.split(',').take(STOPS + 1).map(stop).collect::<Result<_, Error>>()?)
    }
}

impl fmt::Display for Gradient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (place, colour)) in self.0.iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(f, "{comma}{place} {colour}")?;
        }
        Ok(())
    }
}

macro_rules! written_field {
    ($($ty:ty, $kind:expr;)*) => {$(
        impl ParamField for $ty {
            fn kind(_: Option<(f64, f64)>, _: Option<(f64, f64)>) -> ParamKind {
                $kind
            }
            fn to_value(&self) -> ParamValue {
                ParamValue::Text(self.to_string())
            }
            fn from_value(value: &ParamValue) -> Option<Self> {
                match value {
                    ParamValue::Text(text) => text.parse().ok(),
                    _ => None,
                }
            }
        }
    )*};
}
written_field! {
    Colour, ParamKind::Colour;
    Gradient, ParamKind::Gradient;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_as_written_and_written_as_read() {
        assert_eq!("#ff8000".parse(), Ok(Colour([255, 128, 0, 255])));
        assert_eq!("#FF800040".parse(), Ok(Colour([255, 128, 0, 64])));
        for text in ["#ff8000", "#ff800040", "#00000000"] {
            assert_eq!(text.parse::<Colour>().map(|colour| colour.to_string()), Ok(text.to_owned()));
        }
        assert_eq!(Colour::rgb(0x01_02ff), Colour([1, 2, 255, 255]));
        for bad in ["", "#", "ff8000", "#ff80", "#ff80zz", "#ääää", "#+f8000"] {
            assert!(bad.parse::<Colour>().is_err(), "{bad}");
        }
    }

    #[test]
    fn gradients_are_linear_between_stops_and_hold_their_ends() {
        let gradient: Gradient = " 0.25 #000000 ,0.75 #64c80080".parse().unwrap_or_default();
        assert_eq!(gradient.to_string(), "0.25 #000000, 0.75 #64c80080");
        assert_eq!(gradient.to_string().parse(), Ok(gradient.clone()));
        for (share, colour) in [
            (f64::NAN, [0, 0, 0, 255]),
            (-1.0, [0, 0, 0, 255]),
            (0.25, [0, 0, 0, 255]),
            // 255 + (128 - 255) / 2 = 191.5, rounded up.
            (0.5, [50, 100, 0, 192]),
            (0.75, [100, 200, 0, 128]),
            (9.0, [100, 200, 0, 128]),
        ] {
            assert_eq!(gradient.at(share), Some(Colour(colour)), "{share}");
        }
        assert_eq!(Gradient::default().at(0.5), None);
        assert_eq!("".parse(), Ok(Gradient::default()));
    }

    #[test]
    fn what_is_no_gradient_is_refused_with_what_is_wrong() {
        let many = vec!["0 #000000"; 300].join(",");
        for (text, why) in [
            ("#000000", "`#000000` is no stop"),
            ("0 #00", "`#00` is no colour"),
            ("x #000000", "`x #000000` is no stop"),
            ("0 #000000,", "`` is no stop"),
            ("0 #000000, 1.5 #ffffff", "a stop at 1.5"),
            ("NaN #000000", "a stop at NaN"),
            ("0.5 #000000, 0.5 #ffffff", "does not lie above"),
            (many.as_str(), "257 stops"),
        ] {
            let error = text.parse::<Gradient>().map_or_else(|error| error.to_string(), |_| String::new());
            assert!(error.contains(why), "{text}: {error}");
        }
    }
}

//! The numbers of an entity, each checked as it is read.

use super::content::value;
use super::curve::described;
use super::pair::{Pair, Record};
use crate::planning::document::shape::quoted;
use crate::planning::finding::Code;
use crate::planning::geometry::Point3;
use crate::planning::tape::file::faults::Fault;
use crate::planning::tape::wire::LARGEST_MM;
use crate::planning::tolerance::ZERO_NORMAL;

/// The fields of an entity.
pub struct Fields<'a> {
    /// The entity.
    pub record: &'a Record<'a>,
    /// mm per unit of the drawing.
    pub scale: f64,
}

impl<'a> Fields<'a> {
    /// The fields of an entity in a drawing of so many mm per unit.
    #[must_use]
    pub fn of(record: &'a Record<'a>, scale: f64) -> Self {
        Self { record, scale }
    }

    /// The line at which the entity begins.
    #[must_use]
    pub fn line(&self) -> u32 {
        self.record.line
    }

    /// A fault of the entity as a whole.
    #[must_use]
    pub fn fault(&self, code: Code, words: String) -> Fault {
        Fault::new(code, self.line(), format!("{}: {words}", described(self.record)))
    }

    /// Whether it has a field.
    #[must_use]
    pub fn has(&self, code: i32) -> bool {
        value(self.record, code).is_some()
    }

    /// A number that need not be there.
    ///
    /// # Errors
    /// `WrongType` if it is no finite number.
    pub fn number(&self, code: i32) -> Result<Option<f64>, Fault> {
        self.pair(code).map(|pair| self.number_of(pair)).transpose()
    }

    /// A number that must be there.
    ///
    /// # Errors
    /// As [`Fields::number`]; `MissingField`.
    pub fn required(&self, code: i32) -> Result<f64, Fault> {
        let missing = || self.fault(Code::MissingField, format!("it has no group {code}"));
        self.number(code)?.ok_or_else(missing)
    }

    /// A length in mm that must be there.
    ///
    /// # Errors
    /// As [`Fields::required`]; `OutOfRange` beyond the largest coordinate.
    pub fn length(&self, code: i32) -> Result<f64, Fault> {
        let missing = || self.fault(Code::MissingField, format!("it has no group {code}"));
        self.length_of(self.pair(code).ok_or_else(missing)?)
    }

    /// A length in mm; 0 if it is not there.
    ///
    /// # Errors
    /// As [`Fields::length`].
    pub fn optional_length(&self, code: i32) -> Result<f64, Fault> {
        self.pair(code).map_or(Ok(0.0), |pair| self.length_of(pair))
    }

    /// A point in mm; a height that is not there is 0.
    ///
    /// # Errors
    /// As [`Fields::length`].
    pub fn point(&self, [x, y, z]: [i32; 3]) -> Result<Point3, Fault> {
        Ok(Point3::new(self.length(x)?, self.length(y)?, self.optional_length(z)?))
    }

    /// A whole number; 0 if it is not there.
    ///
    /// # Errors
    /// `WrongType` if it is none.
    pub fn flags(&self, code: i32) -> Result<i64, Fault> {
        let Some(pair) = self.pair(code) else { return Ok(0) };
        pair.value.parse().map_err(|_| {
            let message = format!("{} is no whole number (group {code})", quoted(pair.value));
            Fault::new(Code::WrongType, pair.line, message)
        })
    }

    /// 1 for an entity that is drawn from above, -1 for one that is drawn from below: its plane is turned about y.
    ///
    /// # Errors
    /// `NotFlat` for any other extrusion direction.
    pub fn side(&self) -> Result<f64, Fault> {
        let [x, y] = [self.number(210)?.unwrap_or(0.0), self.number(220)?.unwrap_or(0.0)];
        let z = self.number(230)?.unwrap_or(if self.has(210) || self.has(220) { 0.0 } else { 1.0 });
        if x.hypot(y) > ZERO_NORMAL || z.abs() <= ZERO_NORMAL {
            let message = format!("its plane leans: extrusion direction {x} {y} {z}, not along z");
            return Err(self.fault(Code::NotFlat, message));
        }
        Ok(z.signum())
    }

    /// The number of a pair.
    ///
    /// # Errors
    /// `WrongType` if it is no finite number.
    pub fn number_of(&self, pair: &Pair<'_>) -> Result<f64, Fault> {
        pair.value.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
            let message = format!("{} is no number (group {})", quoted(pair.value), pair.code);
            Fault::new(Code::WrongType, pair.line, message)
        })
    }

    /// The length of a pair in mm.
    ///
    /// # Errors
    /// As [`Fields::number_of`]; `OutOfRange` beyond the largest coordinate.
    pub fn length_of(&self, pair: &Pair<'_>) -> Result<f64, Fault> {
        let length = self.number_of(pair)? * self.scale;
        if length.abs() <= LARGEST_MM {
            return Ok(length);
        }
        let message = format!(
            "is {length} mm (group {}); it must lie between -{LARGEST_MM} and {LARGEST_MM}",
            pair.code
        );
        Err(Fault::new(Code::OutOfRange, pair.line, message))
    }

    fn pair(&self, code: i32) -> Option<&'a Pair<'a>> {
        self.record.pairs.iter().find(|pair| pair.code == code)
    }
}

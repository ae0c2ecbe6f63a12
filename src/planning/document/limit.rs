//! The limits of a number, found by where it stands in a document that could not be read.

use super::shape::Shape;

impl Shape {
    /// The limits of the number at a JSON pointer below this shape, in words to be read after "it"; `None` if no number
    /// stands there. Where a field decides what the others are, every choice is looked at.
    #[must_use]
    pub fn limit_at(&self, pointer: &str) -> Option<String> {
        let mut names: Vec<String> = pointer.split('/').skip(1).map(unescaped).collect();
        names.reverse();
        self.limit(names)
    }

    /// `names` are the steps of the way, the next one last.
    fn limit(&self, mut names: Vec<String>) -> Option<String> {
        match self {
            Self::TextOr { shape, .. } | Self::ArrayOrFile(shape) | Self::ObjectOrFile(shape) => {
                return shape.limit(names);
            }
            Self::Number { min, max } => return Some(format!("must lie between {min} and {max}")),
            Self::Integer { min, max } => return Some(format!("must lie between {min} and {max}")),
            Self::Positive { max } => return Some(format!("must be above 0 and at most {max}")),
            Self::Triple { limit } | Self::Pair { limit } => {
                return Some(format!("must lie between -{limit} and {limit}"));
            }
            _ => {}
        }
        let next = names.pop()?;
        match self {
            Self::Object(fields) => {
                fields.iter().find(|field| field.name == next).and_then(|field| field.shape.limit(names))
            }
            Self::Tagged { variants, .. } => variants.iter().find_map(|(_, fields)| {
                let field = fields.iter().find(|field| field.name == next)?;
                field.shape.limit(names.clone())
            }),
            Self::Array { item, .. } => item.limit(names),
            _ => None,
        }
    }
}

fn unescaped(step: &str) -> String {
    step.replace("~1", "/").replace("~0", "~")
}

#[cfg(test)]
mod tests {
    use super::super::JOB;

    #[test]
    fn the_limit_of_any_number_of_a_job_is_found_by_its_pointer() {
        let between = |limit: &str| Some(format!("must lie between {limit}"));
        assert_eq!(JOB.limit_at("/input/tape/width_mm"), between("1 and 2000"));
        assert_eq!(JOB.limit_at("/input/boundary/points/3/1"), between("-100000 and 100000"));
        assert_eq!(JOB.limit_at("/input/tracks/0/points/9/position/2"), between("-100000 and 100000"));
        assert_eq!(JOB.limit_at("/input/tracks/0/number"), between("1 and 1000000"));
        assert_eq!(
            JOB.limit_at("/input/tape/thickness_mm").as_deref(),
            Some("must be above 0 and at most 10")
        );
        assert!(JOB.limit_at("/input/cell/home_deg/0").is_some());
        for nowhere in
            ["", "/", "/input", "/input/nothing", "/name", "/input/machine", "/input/tape/width~1mm"]
        {
            assert_eq!(JOB.limit_at(nowhere), None, "{nowhere}");
        }
    }
}

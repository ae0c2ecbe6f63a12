//! Lengths, angles, speeds and times as types, so that a number cannot change its unit on the way.
//!
//! They stand at the public edges of the planning core. Inside a computation plain `f64`s in mm, rad and s
//! are used, taken out through the accessor that names the unit.

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $from:ident, $get:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            #[doc = concat!("Wraps a number that is in ", $unit, ".")]
            #[must_use]
            pub const fn $from(value: f64) -> Self {
                Self(value)
            }

            #[doc = concat!("The number in ", $unit, ".")]
            #[must_use]
            pub const fn $get(self) -> f64 {
                self.0
            }
        }
    };
}

quantity!(
    /// A length.
    Length, from_mm, mm, "mm"
);
quantity!(
    /// A speed along a line.
    Speed, from_mm_s, mm_s, "mm/s"
);
quantity!(
    /// An acceleration along a line.
    Acceleration, from_mm_s2, mm_s2, "mm/s^2"
);
quantity!(
    /// An angle.
    Angle, from_degrees, degrees, "degrees"
);
quantity!(
    /// A speed of turning.
    AngularSpeed, from_deg_s, deg_s, "deg/s"
);
quantity!(
    /// An acceleration of turning.
    AngularAcceleration, from_deg_s2, deg_s2, "deg/s^2"
);
quantity!(
    /// A duration.
    Duration, from_s, s, "s"
);

impl Angle {
    /// The angle in radians.
    #[must_use]
    pub fn radians(self) -> f64 {
        self.0.to_radians()
    }
}

//! Robot arms and what they can do: data, kinematics, and the check of a path (domain.md B5).

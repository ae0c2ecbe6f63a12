-- The hash of the profile, without its name, that a program was planned for and that a machine has: a program is
-- given only to machines of exactly this profile.
ALTER TABLE programs ADD COLUMN profile_sha256 TEXT;
ALTER TABLE machines ADD COLUMN profile_sha256 TEXT NOT NULL DEFAULT '';

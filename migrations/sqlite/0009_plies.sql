-- Where a roll holds several plies, the number of the course from which on a program goes is one of its kind in its ply
-- only. Programs that are there already say the ply in their names: roll-from-ply-2-course-7.ngc.
ALTER TABLE programs ADD COLUMN from_ply BIGINT;

UPDATE programs SET from_ply = CAST(SUBSTR(content_name, LENGTH('roll-from-ply-') + 1) AS INTEGER)
    WHERE kind = 'tape-cut' AND content_name LIKE 'roll-from-ply-%';

-- What a program is for: only one that makes a whole unit counts as production (src/job/purpose.rs). Those that are
-- there already say it in their names, which the planner has always made from content alone: roll-dry-run.ngc,
-- roll-from-course-7.ngc, roll-from-course-7-dry-run.ngc.
ALTER TABLE programs ADD COLUMN purpose TEXT NOT NULL DEFAULT 'production'
    CHECK (purpose IN ('production', 'dry_run', 'restart'));
ALTER TABLE programs ADD COLUMN from_course BIGINT;

UPDATE programs SET purpose = 'restart',
        from_course = CAST(SUBSTR(content_name, LENGTH('roll-from-course-') + 1) AS INTEGER)
    WHERE kind = 'tape-cut' AND content_name LIKE 'roll-from-course-%';
UPDATE programs SET purpose = 'dry_run' WHERE kind = 'tape-cut' AND content_name LIKE '%-dry-run.%';

-- The job of a program's dry run: asked for twice, it is the same.
ALTER TABLE jobs ADD COLUMN dry_run_of TEXT REFERENCES programs (id);
CREATE INDEX jobs_dry_run_of ON jobs (dry_run_of, id) WHERE dry_run_of IS NOT NULL;

-- The files that came with a job, byte for byte. They never change.
CREATE TABLE job_files (
    job_id TEXT   NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    name   TEXT   NOT NULL,
    sha256 TEXT   NOT NULL,
    bytes  BIGINT NOT NULL,
    body   BLOB   NOT NULL,
    PRIMARY KEY (job_id, name)
);

-- The hash of all files of a job together, so that a lost one shows too (src/store/files.rs says over which bytes);
-- empty where there are none.
ALTER TABLE job_inputs ADD COLUMN files_sha256 TEXT NOT NULL DEFAULT '';

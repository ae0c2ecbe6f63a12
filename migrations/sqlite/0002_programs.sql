-- Programs: what a job gave, for one kind of machine. The rows of program_files never change.
CREATE TABLE programs (
    id               TEXT   NOT NULL PRIMARY KEY,
    job_id           TEXT   NOT NULL UNIQUE REFERENCES jobs (id),
    kind             TEXT   NOT NULL,
    state            TEXT   NOT NULL CHECK (state IN ('draft', 'approved', 'superseded', 'revoked', 'quarantined')),
    content_position BIGINT NOT NULL,
    content_name     TEXT   NOT NULL,
    media_type       TEXT   NOT NULL,
    sha256           TEXT   NOT NULL,
    bytes            BIGINT NOT NULL,
    created_at       BIGINT NOT NULL,
    version          BIGINT NOT NULL
);

CREATE INDEX programs_by_state ON programs (state, id);
CREATE INDEX programs_by_sha256 ON programs (sha256, id);

-- The files of a program; position 0 is the archive of all of them where there are several.
CREATE TABLE program_files (
    program_id TEXT   NOT NULL REFERENCES programs (id),
    position   BIGINT NOT NULL,
    name       TEXT   NOT NULL,
    dialect    TEXT   NOT NULL,
    sha256     TEXT   NOT NULL,
    bytes      BIGINT NOT NULL,
    body       BLOB   NOT NULL,
    PRIMARY KEY (program_id, position),
    UNIQUE (program_id, name)
);

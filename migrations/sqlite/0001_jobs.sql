-- Jobs. Ids are TEXT, times BIGINT milliseconds since 1970, documents TEXT in JSON: the statements in src/store
-- are then the same for PostgreSQL.
CREATE TABLE jobs (
    id           TEXT   NOT NULL PRIMARY KEY,
    kind         TEXT   NOT NULL,
    name         TEXT   NOT NULL,
    labels       TEXT   NOT NULL,
    created_at   BIGINT NOT NULL,
    attempts     BIGINT NOT NULL,
    fence        BIGINT NOT NULL,
    version      BIGINT NOT NULL,
    state        TEXT   NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    queued_since BIGINT,
    life         TEXT   NOT NULL
);

CREATE INDEX jobs_queue ON jobs (queued_since, id) WHERE state = 'queued';
CREATE INDEX jobs_by_state ON jobs (state, id);
CREATE INDEX jobs_by_kind ON jobs (kind, id);

-- The free strings of a job, for looking jobs up.
CREATE TABLE job_references (
    job_id TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    name   TEXT NOT NULL,
    value  TEXT NOT NULL,
    PRIMARY KEY (job_id, name)
);

CREATE INDEX job_references_by_value ON job_references (name, value, job_id);

-- What an attempt plans: the document byte for byte as it was posted, and the registered machine profiles as
-- they stood then, so that a later attempt plans the same.
CREATE TABLE job_inputs (
    job_id   TEXT   NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    sha256   TEXT   NOT NULL,
    bytes    BIGINT NOT NULL,
    machines TEXT   NOT NULL,
    body     BLOB   NOT NULL
);

-- One row for each attempt; the fence is its number within the job.
CREATE TABLE attempts (
    job_id       TEXT   NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    fence        BIGINT NOT NULL,
    worker       TEXT   NOT NULL,
    started_at   BIGINT NOT NULL,
    heartbeat_at BIGINT NOT NULL,
    ended_at     BIGINT,
    ending       TEXT,
    PRIMARY KEY (job_id, fence)
);

CREATE INDEX attempts_open ON attempts (heartbeat_at) WHERE ended_at IS NULL;

-- What a follower of a job is told, in order.
CREATE TABLE job_events (
    job_id TEXT   NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    seq    BIGINT NOT NULL,
    at     BIGINT NOT NULL,
    kind   TEXT   NOT NULL,
    data   TEXT   NOT NULL,
    PRIMARY KEY (job_id, seq)
);

CREATE TABLE reports (
    job_id TEXT NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    sha256 TEXT NOT NULL,
    body   BLOB NOT NULL
);

CREATE TABLE drawings (
    job_id   TEXT   NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    position BIGINT NOT NULL,
    name     TEXT   NOT NULL,
    body     BLOB   NOT NULL,
    PRIMARY KEY (job_id, name)
);

-- A key belongs to whoever sent it: two senders may choose the same name.
CREATE TABLE idempotency_keys (
    actor       TEXT   NOT NULL,
    name        TEXT   NOT NULL,
    body_sha256 TEXT   NOT NULL,
    job_id      TEXT   NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    created_at  BIGINT NOT NULL,
    PRIMARY KEY (actor, name)
);

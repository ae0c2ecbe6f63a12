-- Entries: programs that wait in a queue, each with a quantity of units. A queue is the name of a machine or a pool.
CREATE TABLE entries (
    id         TEXT   NOT NULL PRIMARY KEY,
    queue      TEXT   NOT NULL,
    program_id TEXT   NOT NULL REFERENCES programs (id),
    position   BIGINT NOT NULL,
    quantity   BIGINT NOT NULL CHECK (quantity BETWEEN 1 AND 10000),
    state      TEXT   NOT NULL CHECK (state IN ('queued', 'assigned', 'finished', 'cancelled')),
    created_at BIGINT NOT NULL,
    version    BIGINT NOT NULL
);

CREATE INDEX entries_queue ON entries (queue, position, id) WHERE state = 'queued';

-- Runs: one machine doing one unit of one entry. A unit that has gone back to its queue leaves its run behind
-- with returned = 1; one that a person has given up stays, with scrapped = 1.
CREATE TABLE runs (
    id          TEXT   NOT NULL PRIMARY KEY,
    entry_id    TEXT   NOT NULL REFERENCES entries (id),
    unit        BIGINT NOT NULL,
    program_id  TEXT   NOT NULL REFERENCES programs (id),
    sha256      TEXT   NOT NULL,
    bytes       BIGINT NOT NULL,
    machine     TEXT   NOT NULL REFERENCES machines (name),
    request_id  TEXT   NOT NULL,
    fence       BIGINT NOT NULL,
    state       TEXT   NOT NULL CHECK (state IN ('offered', 'received', 'running', 'suspect', 'done', 'failed', 'aborted')),
    returned    BIGINT NOT NULL DEFAULT 0,
    scrapped    BIGINT NOT NULL DEFAULT 0,
    lease_until BIGINT NOT NULL,
    created_at  BIGINT NOT NULL,
    version     BIGINT NOT NULL,
    life        TEXT   NOT NULL,
    UNIQUE (machine, request_id)
);

-- Cutting is at most once: a unit has one run that counts, and a machine does one thing at a time. A defect in the
-- code that claims is then an error, not a double cut.
CREATE UNIQUE INDEX runs_unit ON runs (entry_id, unit) WHERE returned = 0;
CREATE UNIQUE INDEX runs_machine ON runs (machine) WHERE state IN ('offered', 'received', 'running', 'suspect');
CREATE INDEX runs_lease ON runs (lease_until) WHERE state IN ('offered', 'received', 'running');

-- Keys: who may call the service, as what. Only a hash of the secret is kept.
CREATE TABLE keys (
    id         TEXT   NOT NULL PRIMARY KEY,
    name       TEXT   NOT NULL UNIQUE,
    role       TEXT   NOT NULL CHECK (role IN ('mes', 'engineer', 'approver', 'operator', 'machine', 'auditor', 'admin')),
    machine    TEXT,
    hash       TEXT   NOT NULL,
    created_at BIGINT NOT NULL,
    revoked_at BIGINT,
    CHECK ((role = 'machine') = (machine IS NOT NULL))
);

-- Machines with their profiles. A machine takes work from the queue of its own name and from that of its pool.
CREATE TABLE machines (
    name        TEXT   NOT NULL PRIMARY KEY,
    pool        TEXT,
    profile     TEXT   NOT NULL,
    held_by     TEXT,
    held_reason TEXT,
    held_at     BIGINT,
    created_at  BIGINT NOT NULL,
    version     BIGINT NOT NULL,
    CHECK ((held_by IS NULL) = (held_at IS NULL) AND (held_by IS NULL) = (held_reason IS NULL))
);

-- Who approved which bytes of a program, and who took that back. The state itself stands in programs.
CREATE TABLE approvals (
    program_id TEXT   NOT NULL PRIMARY KEY REFERENCES programs (id),
    sha256     TEXT   NOT NULL,
    actor      TEXT   NOT NULL,
    at         BIGINT NOT NULL
);

CREATE TABLE revocations (
    program_id TEXT   NOT NULL PRIMARY KEY REFERENCES programs (id),
    reason     TEXT   NOT NULL,
    actor      TEXT   NOT NULL,
    at         BIGINT NOT NULL
);

-- Every change of state, written in the transaction that makes the change. Each row carries the hash of the one
-- before it (src/store/audit.rs says over which bytes).
CREATE TABLE audit (
    seq      BIGINT NOT NULL PRIMARY KEY,
    at       BIGINT NOT NULL,
    actor    TEXT   NOT NULL,
    action   TEXT   NOT NULL,
    subject  TEXT   NOT NULL,
    detail   TEXT   NOT NULL,
    previous TEXT   NOT NULL,
    hash     TEXT   NOT NULL UNIQUE
);

CREATE INDEX audit_by_subject ON audit (subject, seq);

-- What is counted but not kept, such as refused posts by code.
CREATE TABLE counters (
    name  TEXT   NOT NULL,
    label TEXT   NOT NULL,
    value BIGINT NOT NULL,
    PRIMARY KEY (name, label)
);

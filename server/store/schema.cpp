#include "server/store/schema.h"

#include <array>

namespace photond {

namespace {

constexpr std::array kSchema{
    Migration{R"(
CREATE TABLE scenes (
  id BLOB PRIMARY KEY,            -- SHA-256 of the file, which is the blob of that name
  arrival INTEGER NOT NULL,       -- ascending
  name TEXT NOT NULL,
  media_type TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  sample INTEGER NOT NULL,
  created_ms INTEGER NOT NULL
) WITHOUT ROWID;

CREATE TABLE jobs (
  id TEXT PRIMARY KEY,
  sequence INTEGER NOT NULL UNIQUE,
  record TEXT NOT NULL            -- record_text.h, without the series
) WITHOUT ROWID;

CREATE TABLE series (
  job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,
  passes INTEGER NOT NULL,
  seconds REAL NOT NULL,
  error TEXT,
  PRIMARY KEY (job, revision)
) WITHOUT ROWID;

CREATE TABLE events (
  id INTEGER PRIMARY KEY,         -- ascending over all jobs, never used twice
  job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  event TEXT NOT NULL
);
CREATE INDEX events_of_job ON events (job);

CREATE TABLE frames (             -- pictures kept on disk: blobs
  job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,
  format INTEGER NOT NULL,
  blob BLOB NOT NULL,
  bytes INTEGER NOT NULL,
  PRIMARY KEY (job, revision, format)
) WITHOUT ROWID;
CREATE INDEX frames_by_blob ON frames (blob);

CREATE TABLE checkpoints (        -- films of unfinished and extensible jobs: blobs
  job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  passes INTEGER NOT NULL,
  blob BLOB NOT NULL,
  bytes INTEGER NOT NULL,
  seconds REAL NOT NULL,          -- of computing, until here
  PRIMARY KEY (job, passes)
) WITHOUT ROWID;
CREATE INDEX checkpoints_by_blob ON checkpoints (blob);
)"},
    Migration{R"(
CREATE TABLE counters (
  name TEXT PRIMARY KEY,
  value INTEGER NOT NULL
) WITHOUT ROWID;
INSERT INTO counters VALUES
  ('job_sequence', 0),            -- the last one given
  ('events_reserved', 0);         -- ids up to here may have been given
)"},
    Migration{R"(
CREATE TABLE environments (
  id BLOB PRIMARY KEY,            -- SHA-256 of the file, which is the blob of that name
  arrival INTEGER NOT NULL,       -- ascending
  media_type TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  width INTEGER NOT NULL,
  height INTEGER NOT NULL,
  warnings TEXT NOT NULL,         -- one a line
  created_ms INTEGER NOT NULL
) WITHOUT ROWID;
)"},
    Migration{R"(
CREATE TABLE answers (            -- to requests with an idempotency key
  owner TEXT NOT NULL,            -- API key id, or empty
  key TEXT NOT NULL,
  request BLOB NOT NULL,          -- SHA-256 of its body
  job TEXT NOT NULL,              -- which may be gone
  etag TEXT NOT NULL,
  status INTEGER NOT NULL,
  body TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (owner, key)
) WITHOUT ROWID;
CREATE INDEX answers_by_age ON answers (created_ms);
)"},
    Migration{R"(
ALTER TABLE scenes ADD COLUMN owner TEXT NOT NULL DEFAULT '';  -- API key id, or empty
)"},
    Migration{R"(
ALTER TABLE environments ADD COLUMN owner TEXT NOT NULL DEFAULT '';  -- as of scenes
)"},
    Migration{R"(
ALTER TABLE environments ADD COLUMN name TEXT NOT NULL DEFAULT '';  -- as of scenes
)"},
    Migration{R"(
CREATE TABLE gone (               -- events that say that a job is gone, the newest ones
  id INTEGER PRIMARY KEY,         -- as of events
  event TEXT NOT NULL
);
)"},
};

}  // namespace

std::span<const Migration> schema() { return kSchema; }

}  // namespace photond

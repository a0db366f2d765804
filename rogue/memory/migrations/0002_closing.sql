-- What was filled in when a request was posted, as JSON, and how it closes.
ALTER TABLE requests ADD COLUMN "then" TEXT NOT NULL DEFAULT 'deliver';
ALTER TABLE requests ADD COLUMN closing TEXT;
ALTER TABLE requests ADD COLUMN warning TEXT;
ALTER TABLE requests ADD COLUMN filled TEXT NOT NULL DEFAULT '[]';
CREATE INDEX requests_by_user ON requests (user);

-- Which requests a step serves, so that the steps of one are found without reading all.
CREATE TABLE served (
    request TEXT NOT NULL,
    step INTEGER NOT NULL REFERENCES steps (number),
    PRIMARY KEY (request, step)
) WITHOUT ROWID;
INSERT OR IGNORE INTO served (request, step)
    SELECT value, number FROM steps, json_each(steps.requests);

-- Who was met through a finger server and is in no directory.
CREATE TABLE people (
    user TEXT PRIMARY KEY,
    person TEXT NOT NULL
) WITHOUT ROWID;

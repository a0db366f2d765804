CREATE TABLE identity (
    name TEXT NOT NULL
);
INSERT INTO identity (name) VALUES (lower(hex(randomblob(4))));

CREATE TABLE requests (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    user TEXT NOT NULL,
    item TEXT NOT NULL,
    pickup TEXT NOT NULL,
    deliver TEXT NOT NULL,
    state TEXT NOT NULL,
    rank INTEGER NOT NULL,
    posted REAL NOT NULL,
    deadline REAL NOT NULL,
    finished REAL,
    reason TEXT,
    why TEXT
);
CREATE INDEX requests_by_state ON requests (state);

CREATE TABLE notes (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    request TEXT NOT NULL REFERENCES requests (id),
    time REAL NOT NULL,
    text TEXT NOT NULL
);
CREATE INDEX notes_by_request ON notes (request);

-- What is known of the world: (tray, user item) and (robot, room).
CREATE TABLE facts (
    kind TEXT NOT NULL,
    subject TEXT NOT NULL,
    PRIMARY KEY (kind, subject)
) WITHOUT ROWID;

CREATE TABLE steps (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    operator TEXT NOT NULL,
    arguments TEXT NOT NULL,
    requests TEXT NOT NULL,
    state TEXT NOT NULL,
    outcome TEXT,
    started REAL NOT NULL,
    ended REAL
);
CREATE INDEX steps_by_state ON steps (state);

-- Outcomes of what an open step has done; a step that is run again reads them instead.
CREATE TABLE outcomes (
    step INTEGER NOT NULL REFERENCES steps (number),
    position INTEGER NOT NULL,
    outcome TEXT NOT NULL,
    PRIMARY KEY (step, position)
) WITHOUT ROWID;

CREATE TABLE trace (
    seq INTEGER PRIMARY KEY AUTOINCREMENT,
    time REAL NOT NULL,
    text TEXT NOT NULL,
    step INTEGER,
    position INTEGER,
    UNIQUE (step, position)
);

-- What the planner decided about each request, and how many decisions were forgotten since.
CREATE TABLE decisions (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    request TEXT NOT NULL,
    time REAL NOT NULL,
    kind TEXT NOT NULL,
    routine INTEGER NOT NULL,
    record TEXT NOT NULL
);
CREATE INDEX decisions_by_request ON decisions (request, routine, number);

CREATE TABLE forgotten (
    request TEXT PRIMARY KEY,
    decisions INTEGER NOT NULL
) WITHOUT ROWID;

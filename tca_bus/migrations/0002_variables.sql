-- The shared variables; "schema" is the JSON schema of the last typed declaration.
CREATE TABLE variables (
    name TEXT PRIMARY KEY,
    state TEXT NOT NULL,
    schema TEXT
);

-- What the latest changes did, by the ids that their senders made.
CREATE TABLE variable_changes (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    change TEXT NOT NULL
);

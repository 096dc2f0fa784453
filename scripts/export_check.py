"""Compares records.parquet of a results directory with its records, read by three libraries."""

import json
import math
import sys
from pathlib import Path

import duckdb
import pandas
import polars

folder = Path(sys.argv[1])
table = str(folder / "records.parquet")
manifest = json.load(open(folder / "manifest.json"))["identity"]
points = {point["point"]: point for point in manifest["points"]}
features = [feature["name"] for feature in manifest["features"]]

expected = []
records = sorted(folder.glob("done/*/*.jsonl"), key=lambda path: int(path.stem))
for path in records:
    summary, *rows = [json.loads(line) for line in open(path)]
    point = points[summary["point"]]
    for row in rows:
        expected.append({
            **{key: summary[key] for key in ["task", "method", "point", "replicate", "outcome"]},
            **{key: row[key] for key in ["kind", "episode", "seed"]},
            "importance": point["importance"],
            **dict(zip(features, point["features"])),
            **row["metrics"],
        })


def compare(name, rows):
    assert len(rows) == len(expected), (name, len(rows), len(expected))
    for got, wanted in zip(rows, expected):
        for key, value in wanted.items():
            same = got[key] == value
            assert same, (name, key, got[key], value)
        for key in got.keys() - wanted.keys():
            empty = got[key] is None or (isinstance(got[key], float) and math.isnan(got[key]))
            assert empty or key in {"title", "weight", "instances"}, (name, key, got[key])
    print(f"{name}: {len(rows)} rows as the records have them")


frame = polars.read_parquet(table)
compare(f"polars {polars.__version__}", frame.to_dicts())
assert frame["seed"].dtype == polars.UInt64 and frame["method"].dtype == polars.String, frame.schema
compare(f"pandas {pandas.__version__}", pandas.read_parquet(table).to_dict("records"))
rows = duckdb.sql(f"select * from '{table}'")
compare(f"DuckDB {duckdb.__version__}", [dict(zip(rows.columns, row)) for row in rows.fetchall()])
objective = manifest["objective"]
mean = duckdb.sql(
    f"select method, avg({objective}) from '{table}' where kind = 'evaluation' group by method order by method"
).fetchall()
for method, value in mean:
    own = [row[objective] for row in expected if row["method"] == method and row["kind"] == "evaluation"]
    assert math.isclose(value, sum(own) / len(own), rel_tol=1e-12), (method, value)

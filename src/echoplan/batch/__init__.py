"""Fleets: every recording below a folder mapped once, by processes of this machine or of a cluster."""

from echoplan.batch.cluster import cluster_executor
from echoplan.batch.discovery import Recorded, find_recordings
from echoplan.batch.jobs import Job, finished_rows, plan_jobs, run_job
from echoplan.batch.local import LocalProcesses
from echoplan.batch.rows import Row, rows_csv, rows_parquet
from echoplan.batch.running import run_jobs

__all__ = [
    "Job",
    "LocalProcesses",
    "Recorded",
    "Row",
    "cluster_executor",
    "find_recordings",
    "finished_rows",
    "plan_jobs",
    "rows_csv",
    "rows_parquet",
    "run_job",
    "run_jobs",
]

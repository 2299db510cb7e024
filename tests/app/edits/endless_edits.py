"""A process that edits one track until it is killed, or until its file was full and has room again."""

from __future__ import annotations

import resource
import signal

from sqlalchemy.exc import DBAPIError

from app.storage.database import storage_failure
from tests.app.edits.edit_services import make_edit_services
from tests.app.edits.sent_edits import relabel, send


def main(arguments: list[str]) -> int:
    """Edit and print the number of each edit; once the file is full, print the failure and the number of edits.

    Args:
        arguments: the SQLite file, and perhaps the largest size of a file, bytes.
    """
    edits = make_edit_services(f"sqlite:///{arguments[0]}")
    if len(arguments) > 1:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(arguments[1]), resource.RLIM_INFINITY))
    known, full = 0, False
    for step in range(100000):
        try:
            known = send(edits, str(step), relabel(step % 43), {"m1": known}).docs[0].revision
            print(step, flush=True)
        except DBAPIError as error:
            if full:
                raise
            failure = storage_failure(error)
            told = f"{failure.status}:{failure.code}" if failure else error
            print("full", told, len(edits.service.log(edits.run, 0, 10**6)), flush=True)
            resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            full = True
        if full and known and step % 10 == 0:
            break
    return 0

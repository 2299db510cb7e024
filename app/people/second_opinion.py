"""Second opinions by sample: another person judges accepted tracks without seeing the first answer.

A track is in the sample of 5 % if a number derived from its run and key is below 0.05. So no person chooses the tracks,
and a repeated request assigns only tracks that were accepted since.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime

from sqlalchemy import ColumnElement, and_, delete, func, select, true
from sqlalchemy.orm import Session

from app.body_model import Model
from app.errors import Conflict, Invalid, NotFound, Refused
from app.events import EventBus
from app.labels.store import newest
from app.people.agreement_statistics import by_name, label_name, share_interval
from app.people.assignments import require_worker
from app.people.box_agreement import BoxAgreements, box_agreements
from app.people.identity import Identity
from app.people.service import person_named
from app.storage.database import Database
from app.storage.lookup import in_parts
from app.storage.models import SearchTrack, SecondOpinion, Video
from tsr_engine.labels.model import NO_LABEL, LabelSet

_MAX_DISPUTES = 200


class Given(Model):
    """Number of tracks that were assigned."""

    given: int
    accepted: int
    """Number of tracks of the library that others have accepted."""
    unread: int
    """Number of runs whose tracks or newest edits are not included yet."""


class LabelChoice(Model):
    """A label that can be chosen."""

    id: int
    name: str


class Look(Model):
    """A sign to look at, without the first person's answer."""

    id: int
    run_id: str
    video_name: str
    frame: int
    box: tuple[float, float, float, float]
    labels: list[LabelChoice]


class NextLook(Model):
    """The next sign for a person to look at."""

    look: Look | None
    left: int


class Agreement(Model):
    """How often second answers equal the first."""

    name: str
    looked: int
    agreed: int
    low: float
    """Lower end of the 95 % interval of the share."""
    high: float


class Dispute(Model):
    """A track with different answers of two people that nobody has changed since."""

    run_id: str
    video_id: str
    video_name: str
    key: str
    frame: int
    first: str
    first_answer: str
    second: str
    second_answer: str


class SecondOpinions(Model):
    """Results of second opinions."""

    open: int
    """Number of looks that are assigned and not answered."""
    whole: Agreement
    labels: list[Agreement]
    first: list[Agreement]
    """By the person who accepted the track."""
    second: list[Agreement]
    """By the person who gave the second answer."""
    boxes: BoxAgreements
    """Overlap of boxes of tracks that two people have drawn, with or without a second opinion."""
    disputes: list[Dispute]
    """The first disputes."""
    disputed: int


class SecondOpinionService:
    """Second opinions of a library."""

    def __init__(self, database: Database, events: EventBus) -> None:
        self._database = database
        self._events = events

    def give(self, name: str, share: float, unread: int) -> Given:
        """Assign to a person the sampled tracks that others have accepted and that nobody has been assigned yet.

        Args:
            name: name of the person.
            share: share of all accepted tracks, in [0, 1].
            unread: number of runs that are not in the search's tables yet.

        Raises:
            NotFound: no such person.
            Invalid: the person is a viewer.
        """
        row = SearchTrack
        with self._database.write() as session:
            self._events.order(session)  # parallel requests must not assign the same track
            person = person_named(session, name)
            require_worker(person)
            unassigned = SecondOpinion.person_id.is_(None), SecondOpinion.answered.is_(None)
            session.execute(delete(SecondOpinion).where(*unassigned))  # looks of people who were removed
            accepted = select(row.run_id, row.key, row.label, row.set_key, row.revision, row.author).where(
                row.current == true(), row.state == "accepted", row.author.is_not(None), row.author != person.name
            )
            sampled = {(run, key) for run, key in session.execute(select(SecondOpinion.run_id, SecondOpinion.key))}
            count = given = 0
            for run, key, label, set_key, revision, author in session.execute(accepted):
                count += 1
                if author is not None and _sample_number(run, key) < share and (run, key) not in sampled:
                    given += 1
                    look = SecondOpinion(run_id=run, key=key, set_key=set_key, person_id=person.id, second=person.name)
                    look.first, look.first_label, look.revision = author, label, revision
                    session.add(look)
            return Given(given=given, accepted=count, unread=unread)

    def next(self, who: Identity) -> NextLook:
        """Return the next sign for a person; signs that were deleted since are skipped."""
        open_looks = SecondOpinion.person_id == who.person, SecondOpinion.answered.is_(None)
        with self._database.read() as session:
            shown = (
                select(SecondOpinion, SearchTrack, Video.name)
                .join(SearchTrack, _same_track())
                .join(Video, Video.id == SearchTrack.video_id)
            )
            found = session.execute(shown.where(*open_looks).order_by(SecondOpinion.id).limit(1)).first()
            if who.person is None or found is None:
                return NextLook(look=None, left=0)
            left = select(func.count()).select_from(SecondOpinion).join(SearchTrack, _same_track()).where(*open_looks)
            look, track, video = found
            offered = [LabelChoice(id=label.id, name=label.name) for label in newest(session, look.set_key).offered()]
            return NextLook(
                look=Look(
                    id=look.id,
                    run_id=look.run_id,
                    video_name=video,
                    frame=track.frame,
                    box=(round(track.x1, 2), round(track.y1, 2), round(track.x2, 2), round(track.y2, 2)),
                    labels=offered,
                ),
                left=session.scalar(left) or 0,
            )

    def answer(self, who: Identity, look_id: int, label: int | None) -> None:
        """Store an answer.

        Args:
            who: the person to whom the track was assigned.
            look_id: the look.
            label: id of a label, -1: none of the set; None: it is no sign.

        Raises:
            NotFound: no such look.
            Refused: it was assigned to another person.
            Conflict: it is already answered.
            Invalid: the label set has no such label.
        """
        with self._database.write() as session:
            look = session.get(SecondOpinion, look_id, with_for_update=True)
            if look is None:
                raise NotFound("There is no such second opinion (any more).")
            if who.person is None or look.person_id != who.person:
                raise Refused(f"This second opinion was assigned to {look.second}.", code="not_yours")
            if look.answered is not None:
                raise Conflict("This second opinion is already answered.", code="answered")
            if label not in (None, NO_LABEL) and newest(session, look.set_key).get(label) is None:
                raise Invalid(f"The label set '{look.set_key}' has no label {label}.", field="label")
            look.second_label, look.answered = label, datetime.now(UTC)

    def report(self) -> SecondOpinions:
        """Compute the agreement by label and by person, and list the disputed tracks."""
        with self._database.read() as session:
            looks = session.scalars(select(SecondOpinion).order_by(SecondOpinion.id)).all()
            answered = [look for look in looks if look.answered is not None]
            sets = {key: newest(session, key) for key in {look.set_key for look in answered}}
            agree = {look.id: _agree(sets[look.set_key], look) for look in answered}
            disputed = [look for look in answered if not agree[look.id]]
            disputes = _disputes(session, disputed, sets)
            boxes = box_agreements(session)
        return SecondOpinions(
            open=len(looks) - len(answered),
            whole=_agreement("all", list(agree.values())),
            labels=_by_name([(label_name(sets[each.set_key], each.first_label), agree[each.id]) for each in answered]),
            first=_by_name([(each.first, agree[each.id]) for each in answered]),
            second=_by_name([(each.second, agree[each.id]) for each in answered]),
            boxes=boxes,
            disputes=disputes[:_MAX_DISPUTES],
            disputed=len(disputes),
        )


def _same_track() -> ColumnElement[bool]:
    return and_(SearchTrack.run_id == SecondOpinion.run_id, SearchTrack.key == SecondOpinion.key)


def _sample_number(run: str, key: str) -> float:
    """A number in [0, 1) derived from a track, random but always the same."""
    return int.from_bytes(hashlib.blake2b(f"{run} {key}".encode(), digest_size=6).digest(), "big") / 2**48


def _agree(labels: LabelSet, look: SecondOpinion) -> bool:
    if look.second_label is None:
        return False
    return labels.resolved(look.second_label) == labels.resolved(look.first_label)


def _by_name(answers: Iterable[tuple[str, bool]]) -> list[Agreement]:
    return [_agreement(name, agrees) for name, agrees in by_name(answers)]


def _agreement(name: str, answers: Sequence[bool]) -> Agreement:
    low, high = share_interval(sum(answers), len(answers))
    return Agreement(name=name, looked=len(answers), agreed=sum(answers), low=round(low, 4), high=round(high, 4))


def _disputes(session: Session, disputed: Sequence[SecondOpinion], sets: dict[str, LabelSet]) -> list[Dispute]:
    present: dict[tuple[str, str], tuple[SearchTrack, str]] = {}
    for runs in in_parts(sorted({look.run_id for look in disputed})):
        in_runs = SecondOpinion.run_id.in_(runs)
        query = select(SearchTrack, Video.name).join(SecondOpinion, _same_track())
        for track, video in session.execute(query.join(Video, Video.id == SearchTrack.video_id).where(in_runs)):
            present[track.run_id, track.key] = track, video
    return [
        Dispute.from_row(
            look,
            video_id=track.video_id,
            video_name=video,
            frame=track.frame,
            first_answer=label_name(sets[look.set_key], look.first_label),
            second_answer=label_name(sets[look.set_key], look.second_label),
        )
        for look in disputed
        if (found := present.get((look.run_id, look.key))) is not None
        for track, video in [found]
        if track.revision == look.revision
    ]

// @ts-check
/** The screen of the team: progress of the library and statistics of work, or the activity of one person. */

import { sentence } from '../api/errors.js';
import { commandName } from '../editing/command_names.js';
import { formatRoute } from '../model/route.js';
import { tracksPerHour, may } from '../model/team.js';
import { trackName } from '../model/track_name.js';
import { fill, h } from './dom.js';
import { emptyState, failure, waiting } from './empty.js';
import { count, moment, percent, plural } from '../model/format.js';
import { agreementOf, secondOpinionOf } from './second-opinion.js';
import { pageHead, tableHead } from './heads.js';

/** @typedef {import('../types.js').Worker} Worker */

/**
 * @param {import('../page-types.js').App} app
 * @returns {import('../page-types.js').View}
 */
export function createTeam(app) {
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  const inner = h('div.library-inner.page-inner');
  const element = h('div.library', inner);
  /** @type {string|null} */ let shown = null;

  /** @param {string|null} person */
  async function load(person) {
    fill(inner, h('div.library-notice', waiting('Loading the figures', { signal, retry: () => void load(person) })));
    try {
      const made = person === null ? await wholeTeam() : activityOf(app, await app.api.activity(person, null, { signal }), signal);
      fill(inner, ...made);
    } catch (thrown) {
      if (signal.aborted) return;
      fill(
        inner,
        h(
          'div.library-notice',
          failure('The figures could not be loaded', thrown, () => load(person)),
        ),
      );
    }
  }

  async function wholeTeam() {
    const [overview, looks, people] = await Promise.all([
      app.api.overview({ signal }),
      app.api.secondOpinions({ signal }),
      app.api.people({ signal }),
    ]);
    const workers = people.filter(({ role }) => role !== 'viewer').map(({ name }) => name);
    return [...overviewOf(overview), agreementOf(app, looks, workers, signal, () => void load(null)), mineOf(app, signal)];
  }

  return {
    element,
    update({ route, session }) {
      if (route.screen !== 'team' || session === null) return;
      // a person who may not see the figures of all sees their own
      const person = route.person ?? (may(session, 'reviewer') ? null : (session.person?.name ?? null));
      const key = person ?? '';
      if (key === shown) return;
      shown = key;
      void load(person);
    },
    destroy() {
      ended.abort();
      element.remove();
    },
  };
}

/** @param {import('../types.js').Overview} overview */
function overviewOf(overview) {
  const left = overview.tracks - overview.reviewed;
  const facts = [
    [count(overview.reviewed), `of ${plural(overview.tracks, 'track')} decided`],
    [count(left), 'left'],
    [count(overview.rejected), 'false positives'],
    [count(overview.notes), overview.notes === 1 ? 'note' : 'notes'],
    [
      overview.decided_twice ? percent(overview.agreed / overview.decided_twice) : 'none',
      overview.decided_twice
        ? `agreement on ${plural(overview.decided_twice, 'track')} that two people decided`
        : 'of the tracks was decided by two people',
    ],
  ];
  return [
    pageHead('Team', plural(overview.videos, 'video')),
    overview.unread > 0 &&
      h('p.card-message.small', { role: 'status' }, `The tracks or newest edits of ${plural(overview.unread, 'run')} are not counted.`),
    overview.clocks && h('p.card-message.card-message-warn.small', { role: 'status' }, overview.clocks),
    h('ul.team-facts', { 'aria-label': 'The library' }, ...facts.map(([value, words]) => h('li', h('strong', value), ' ', words))),
    h('h2', 'People ', h('span.muted.small', 'the last 30 days')),
    h(
      'div.team-people',
      h(
        'table.table.team-table',
        tableHead(['Name', 'Role'], ['Decided', 'An hour', 'False positives', 'Hours', 'Assigned', 'In review']),
        h('tbody', ...overview.people.map(personRow)),
      ),
    ),
  ];
}

/**
 * The second opinions of the person who is signed in.
 *
 * @param {import('../page-types.js').App} app
 * @param {AbortSignal} signal
 */
function mineOf(app, signal) {
  const { session } = app.store.get();
  return session?.person && may(session, 'annotator') ? secondOpinionOf(app, signal) : null;
}

/** @param {Worker} worker */
function personRow(worker) {
  const numbers = [
    count(worker.decided),
    tracksPerHour(worker) ?? '–',
    count(worker.rejected),
    worker.hours.toFixed(1),
    count(worker.assigned),
    count(worker.in_review),
  ];
  const name =
    worker.role === null
      ? h('span', { title: 'An author without an account' }, worker.name)
      : h('a', { href: formatRoute({ screen: 'team', person: worker.name }) }, worker.name);
  return h(
    'tr',
    h('th', { scope: 'row', dir: 'auto' }, name),
    h('td', worker.role ?? 'no account'),
    ...numbers.map((value) => h('td.number', value)),
  );
}

/**
 * @param {import('../page-types.js').App} app
 * @param {import('../types.js').Activity} activity
 * @param {AbortSignal} signal
 */
function activityOf(app, activity, signal) {
  const { worker } = activity;
  const speed = tracksPerHour(worker);
  const list = h('ol.activity', { 'aria-label': 'Activity, newest first' }, ...activity.done.map(doneRow));
  const own = app.store.get().session?.person?.name === worker.name;
  let before = activity.more;
  const problem = h('p.field-error', { role: 'alert' });
  const more = h(
    'button.btn',
    {
      hidden: before === null,
      onclick: async () => {
        try {
          const next = await app.api.activity(worker.name, before, { signal });
          before = next.more;
          more.hidden = before === null;
          list.append(...next.done.map(doneRow));
        } catch (thrown) {
          if (!signal.aborted) problem.textContent = sentence(thrown);
        }
      },
    },
    'Show earlier',
  );
  return [
    pageHead(worker.name, worker.role, may(app.store.get().session, 'reviewer') && h('a.btn', { href: '#/team' }, 'The whole team')),
    h(
      'p',
      `${plural(worker.decided, 'track')} decided in ${worker.hours < 0.1 ? 'less than 0.1' : worker.hours.toFixed(1)} hours of the last 30 days${speed === null ? '' : `, ${speed} an hour`}. ${worker.assigned ? `${plural(worker.assigned, 'assignment')} not done.` : 'No open assignment.'}`,
    ),
    own && mineOf(app, signal),
    activity.done.length === 0
      ? h(
          'div.library-notice',
          emptyState({ icon: 'info', title: 'Nothing yet', text: 'Every correction, verdict and note is listed here.' }),
        )
      : list,
    problem,
    more,
  ];
}

/** @param {import('../types.js').Done} done */
function doneRow(done) {
  const track = done.count === 1 ? done.tracks[0] : null;
  const words = track !== null ? `track ${trackName(track)}` : plural(done.count, 'track');
  return h(
    'li',
    h('span.muted.small.activity-time', moment(done.time)),
    h('span', commandName(done.name)),
    h(
      'a.truncate',
      { dir: 'auto', href: formatRoute({ screen: 'review', video: done.video_id, run: done.run_id, frame: done.frame, track }) },
      `${words} of ${done.video_name}`,
    ),
  );
}

// @ts-check
/** The screen of the team: progress of the library and statistics of work, or the activity of one person. */

import { errorMessage } from '../api/errors.js';
import { commandName } from '../editing/command_names.js';
import { formatRoute } from '../model/route.js';
import { tracksPerHour, hasRole } from '../model/team.js';
import { trackName } from '../model/track_name.js';
import { fill, h } from './dom.js';
import { emptyState, errorState, loadingState } from './placeholders.js';
import { count, moment, percent, plural } from '../model/format.js';
import { createAgreementSection, createSecondOpinionForm } from './second_opinion.js';
import { pageHeading, tableHeading } from './headings.js';

/** @typedef {import('../types.js').Worker} Worker */

/** @type {import('../page-types.js').CreateView} */
export function createTeam(app) {
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const container = h('div.library-inner.page-inner');
  const element = h('div.library', container);
  /** @type {string|null} */ let shownKey = null;
  let latestRequest = 0;

  /** @param {string|null} person */
  async function load(person) {
    const request = ++latestRequest;
    fill(container, h('div.library-notice', loadingState('Loading the figures', { signal, retry: () => void load(person) })));
    try {
      const sections = person === null ? await loadTeam() : renderActivity(app, await app.api.activity(person, null, { signal }), signal);
      if (request === latestRequest) fill(container, ...sections);
    } catch (thrown) {
      if (signal.aborted || request !== latestRequest) return;
      fill(
        container,
        h(
          'div.library-notice',
          errorState('The figures could not be loaded', thrown, () => load(person)),
        ),
      );
    }
  }

  async function loadTeam() {
    const [overview, opinions, people] = await Promise.all([
      app.api.overview({ signal }),
      app.api.secondOpinions({ signal }),
      app.api.people({ signal }),
    ]);
    const workers = people.filter(({ role }) => role !== 'viewer').map(({ name }) => name);
    return [
      ...renderOverview(overview),
      createAgreementSection(app, opinions, workers, signal, () => void load(null)),
      ownSecondOpinion(app, signal),
    ];
  }

  return {
    element,
    update({ route, session }) {
      if (route.screen !== 'team' || session === null) return;
      // a person who may not see the figures of all sees their own
      const person = route.person ?? (hasRole(session, 'reviewer') ? null : (session.person?.name ?? null));
      const key = person ?? '';
      if (key === shownKey) return;
      shownKey = key;
      void load(person);
    },
    destroy: () => lifetime.abort(),
  };
}

/** @param {import('../types.js').Overview} overview */
function renderOverview(overview) {
  const left = overview.tracks - overview.reviewed;
  const figures = [
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
    pageHeading('Team', plural(overview.videos, 'video')),
    overview.unread > 0 &&
      h('p.card-message.small', { role: 'status' }, `The tracks or newest edits of ${plural(overview.unread, 'run')} are not counted.`),
    overview.clocks && h('p.card-message.card-message-warn.small', { role: 'status' }, overview.clocks),
    h('ul.team-facts', { 'aria-label': 'The library' }, ...figures.map(([value, text]) => h('li', h('strong', value), ' ', text))),
    h('h2', 'People ', h('span.muted.small', 'the last 30 days')),
    h(
      'div.team-people',
      h(
        'table.table.team-table',
        tableHeading(['Name', 'Role'], ['Decided', 'An hour', 'False positives', 'Hours', 'Assigned', 'In review']),
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
function ownSecondOpinion(app, signal) {
  const { session } = app.store.get();
  return session?.person && hasRole(session, 'annotator') ? createSecondOpinionForm(app, signal) : null;
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

/** @param {import('../page-types.js').App} app @param {import('../types.js').Activity} activity @param {AbortSignal} signal */
function renderActivity(app, activity, signal) {
  const { worker } = activity;
  const perHour = tracksPerHour(worker);
  const list = h('ol.activity', { 'aria-label': 'Activity, newest first' }, ...activity.done.map(activityRow));
  const isOwn = app.store.get().session?.person?.name === worker.name;
  let cursor = activity.more;
  const problem = h('p.field-error', { role: 'alert' });
  const more = h(
    'button.btn',
    {
      hidden: cursor === null,
      onclick: async () => {
        more.disabled = true; // a second click would append the same rows again
        try {
          const next = await app.api.activity(worker.name, cursor, { signal });
          cursor = next.more;
          more.hidden = cursor === null;
          list.append(...next.done.map(activityRow));
          problem.textContent = '';
        } catch (thrown) {
          if (!signal.aborted) problem.textContent = errorMessage(thrown);
        } finally {
          more.disabled = false;
        }
      },
    },
    'Show earlier',
  );
  return [
    pageHeading(worker.name, worker.role, hasRole(app.store.get().session, 'reviewer') && h('a.btn', { href: '#/team' }, 'The whole team')),
    h(
      'p',
      `${plural(worker.decided, 'track')} decided in ${worker.hours < 0.1 ? 'less than 0.1' : worker.hours.toFixed(1)} hours of the last 30 days${perHour === null ? '' : `, ${perHour} an hour`}. ${worker.assigned ? `${plural(worker.assigned, 'assignment')} not done.` : 'No open assignment.'}`,
    ),
    isOwn && ownSecondOpinion(app, signal),
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
function activityRow(done) {
  const track = done.count === 1 ? done.tracks[0] : null;
  const target = track !== null ? `track ${trackName(track)}` : plural(done.count, 'track');
  return h(
    'li',
    h('span.muted.small.activity-time', moment(done.time)),
    h('span', commandName(done.name)),
    h(
      'a.truncate',
      { dir: 'auto', href: formatRoute({ screen: 'review', video: done.video_id, run: done.run_id, frame: done.frame, track }) },
      `${target} of ${done.video_name}`,
    ),
  );
}

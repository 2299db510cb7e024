// @ts-check
/** The changes of the selected track with author, time and earlier value. Loaded when the section is opened. */

import { errorMessage } from '../../api/errors.js';
import { commandName } from '../../editing/command_names.js';
import { describeDifference } from '../../model/team.js';
import { seek } from '../../store/actions/review.js';
import { fill, h } from '../dom.js';
import { moment } from '../../model/format.js';

/** @typedef {import('../../types.js').Happened} Happened */

/** @param {import('../../page-types.js').ViewApp} app @param {AbortSignal} signal */
export function createHistory(app, signal) {
  const list = h('ol.history', { 'aria-label': 'Changes of this track, newest first' });
  const more = h('button.btn.btn-small', { hidden: true, onclick: () => void load(false) }, 'Show earlier changes');
  const notice = h('p.small.muted', { role: 'status' });
  const section = h(
    'details.inspector-section.inspector-history',
    { ontoggle: () => void load(true) },
    h('summary', h('h3', 'History')),
    list,
    notice,
    more,
  );
  /** Run, track and revision of the list. */
  let shownKey = '';
  let loadedKey = '';
  /** @type {number|null} */ let cursor = null;

  /** @param {Happened} change */
  function row(change) {
    const { labels } = app.store.get();
    return h(
      'li',
      h(
        'div.row.small',
        h('strong.truncate', { dir: 'auto' }, change.author),
        h('span.muted.grow', moment(change.time)),
        change.frame !== null &&
          h(
            'button.btn-link.small',
            { onclick: () => app.store.dispatch(seek, /** @type {number} */ (change.frame)) },
            `frame ${change.frame}`,
          ),
      ),
      h('div', commandName(change.name)),
      ...change.differences.map((each) => h('div.small.muted.history-difference', { dir: 'auto' }, describeDifference(each, labels))),
    );
  }

  /** @param {boolean} reload */
  async function load(reload) {
    if (!section.open || shownKey === '' || (reload && loadedKey === shownKey)) return;
    const requestedKey = shownKey;
    const [run, key] = requestedKey.split(' ');
    if (reload) {
      cursor = null;
      // the rows of another track must not stay if this request fails
      if (!loadedKey.startsWith(`${run} ${key} `)) {
        fill(list);
        more.hidden = true;
      }
    }
    loadedKey = requestedKey;
    more.disabled = true; // a second click would append the same rows again
    try {
      const found = await app.api.trackHistory(run, key, cursor, { signal });
      if (shownKey !== requestedKey) return;
      cursor = found.more;
      more.hidden = found.more === null;
      if (reload) fill(list);
      list.append(...found.happened.map(row));
      notice.textContent = list.children.length === 0 ? 'Nobody has changed this track.' : '';
    } catch (thrown) {
      if (signal.aborted || shownKey !== requestedKey) return;
      loadedKey = '';
      notice.textContent = errorMessage(thrown);
    } finally {
      if (shownKey === requestedKey) more.disabled = false;
      else if (loadedKey === requestedKey) loadedKey = ''; // left meanwhile, so the answer is not shown
    }
  }

  return {
    element: section,
    /** @param {import('./index.js').Inspected} inspected */
    update({ entry, doc, review }) {
      const nextKey = `${review.run?.id ?? ''} ${entry.key} ${review.unsaved.length > 0 ? 'unsaved' : (doc?.revision ?? 0)}`;
      if (nextKey === shownKey) return;
      shownKey = nextKey;
      void load(true);
    },
  };
}

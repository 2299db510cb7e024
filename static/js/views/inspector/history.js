// @ts-check
/** The changes of the selected track with author, time and earlier value. Loaded when the section is opened. */

import { sentence } from '../../api/errors.js';
import { commandName } from '../../editing/command_names.js';
import { describeDifference } from '../../model/team.js';
import { seek } from '../app.js';
import { fill, h } from '../dom.js';
import { moment } from '../../model/format.js';

/** @typedef {import('../../types.js').Happened} Happened */

/** @param {import('../app.js').ViewApp} app @param {AbortSignal} signal */
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
  let about = '';
  let loaded = '';
  /** @type {number|null} */ let before = null;

  /** @param {Happened} one */
  function row(one) {
    const { labels } = app.store.get();
    return h(
      'li',
      h(
        'div.row.small',
        h('strong.truncate', { dir: 'auto' }, one.author),
        h('span.muted.grow', moment(one.time)),
        one.frame !== null &&
          h('button.btn-link.small', { onclick: () => seek(app, /** @type {number} */ (one.frame)) }, `frame ${one.frame}`),
      ),
      h('div', commandName(one.name)),
      ...one.differences.map((each) => h('div.small.muted.history-difference', { dir: 'auto' }, describeDifference(each, labels))),
    );
  }

  /** @param {boolean} anew */
  async function load(anew) {
    if (!section.open || about === '' || (anew && loaded === about)) return;
    const wanted = about;
    const [run, key] = wanted.split(' ');
    loaded = wanted;
    if (anew) before = null;
    try {
      const found = await app.api.trackHistory(run, key, before, { signal });
      if (about !== wanted) return;
      before = found.more;
      more.hidden = found.more === null;
      if (anew) fill(list);
      list.append(...found.happened.map(row));
      notice.textContent = list.children.length === 0 ? 'Nobody has changed this track.' : '';
    } catch (thrown) {
      if (signal.aborted || about !== wanted) return;
      loaded = '';
      notice.textContent = sentence(thrown);
    }
  }

  return {
    element: section,
    /** @param {import('./index.js').Inspected} inspected */
    update({ entry, doc, review }) {
      const now = `${review.run?.id ?? ''} ${entry.key} ${review.unsaved.length > 0 ? 'unsaved' : (doc?.revision ?? 0)}`;
      if (now === about) return;
      about = now;
      void load(true);
    },
  };
}

// @ts-check
/** The differences of a what-if: tracks gained, lost, switched, relabelled. Each opens its frame. */

import { engineName } from '../model/labels.js';
import { formatRoute } from '../model/route.js';
import { h } from './dom.js';
import { showInReview } from './show_in_review.js';
import { count, plural } from '../model/format.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Label} Label */
/** @typedef {{key: string, text: string, frame: number, track: number, isReplayTrack: boolean}} Change */

const KINDS = /** @type {const} */ ([
  ['gained', 'Gained', 'Tracks that only the replay has.'],
  ['lost', 'Lost', 'Tracks that only the run has.'],
  ['switched', 'Switched', 'Tracks of the run that the replay splits into several.'],
  ['relabelled', 'Relabelled', 'Tracks that get another class.'],
]);

/**
 * The entries of one kind, with their texts.
 *
 * @param {Run} run     a complete what-if
 * @param {'gained'|'lost'|'switched'|'relabelled'} kind
 * @param {readonly Label[]} labels
 * @returns {Change[]}   isReplayTrack: the track is the what-if's, not the run's
 */
export function listChanges(run, kind, labels) {
  /** @type {Record<string, any>[]} */ const entries = run.summary.difference?.[kind] ?? [];
  /** @param {number|null} id @param {string|null|undefined} word */
  const nameOf = (id, word) => engineName(labels, id, word);
  return entries.map((entry, at) => {
    const text =
      kind === 'switched'
        ? `into ${entry.parts.length} parts at frame ${count(entry.frame)}`
        : kind === 'relabelled'
          ? `${nameOf(entry.before, entry.words?.[0])} → ${nameOf(entry.after, entry.words?.[1])}`
          : `${nameOf(entry.class_id, entry.word)}, frames ${count(entry.frame)}–${count(entry.last)}`;
    return { key: `${kind}${at}`, text, frame: entry.frame, track: entry.track, isReplayTrack: kind === 'gained' || kind === 'relabelled' };
  });
}

/**
 * Number of frames with any difference.
 *
 * @param {Run} run   a complete replay
 * @returns {number}
 */
export function changedFrameCount(run) {
  return run.frames_done - (run.summary.identical_frames ?? run.frames_done);
}

/** @param {import('../page-types.js').App} app @param {Run} run @param {{close?: () => void}} [options] @returns {HTMLElement} */
export function createChangeList(app, run, { close } = {}) {
  const { labels } = app.store.get();
  const counts = run.summary.difference?.counts ?? {};
  const total = KINDS.reduce((sum, [kind]) => sum + (counts[kind] ?? 0), 0);
  const changed = changedFrameCount(run);
  if (total === 0 && changed === 0) return h('p.muted', 'No change: every frame has the same result.');
  const frames = `${count(changed)} of ${plural(run.frames_done, 'frame')} ${changed === 1 ? 'differs' : 'differ'} in boxes, verdicts or votes.`;
  if (total === 0) return h('p.muted', `The same tracks, with the same classes. ${frames} Compare shows how much.`);
  /** @param {Change} change */
  function open(change) {
    close?.();
    // Entries of the replay open the replay, those of the run open the run; the other one is shown on top.
    const shown = change.isReplayTrack ? run.id : (run.parent_id ?? run.id);
    const otherRun = change.isReplayTrack ? run.parent_id : run.id;
    showInReview(app, shown, { second: otherRun === null ? null : { run: otherRun, corrected: false } });
    location.hash = formatRoute({ screen: 'review', video: run.video_id, run: shown, frame: change.frame, track: `m${change.track}` });
  }
  return h(
    'div.changes',
    h('p.muted.small', frames),
    ...KINDS.map(([kind, title, text]) => {
      const changes = listChanges(run, kind, labels);
      const kindCount = counts[kind] ?? changes.length;
      return h(
        'details.details.changes-kind',
        { open: changes.length > 0 && changes.length <= 40 },
        h('summary', { title: text }, title, h('span', { class: `badge ${kindCount ? 'badge-accent' : ''}` }, count(kindCount))),
        h(
          'ul.changes-list',
          ...changes.map((change) =>
            h(
              'li',
              h(
                'button.change-row',
                { onclick: () => open(change) },
                h('span.mono', `#${change.track}`),
                h('span.truncate.grow', change.text),
                h('span.muted.small', `frame ${count(change.frame)}`),
              ),
            ),
          ),
        ),
        kindCount > changes.length && h('p.muted.small', `The first ${count(changes.length)} of ${count(kindCount)}.`),
        kindCount === 0 && h('p.muted.small', 'None.'),
      );
    }),
  );
}

// @ts-check
/** Resolve a conflict: somebody else saved the same track first. Shows both versions side by side. */

import { errorMessage } from '../../api/errors.js';
import { commandName, describeUndone, withTrackNames } from '../../editing/command_names.js';
import { verdictOf } from '../../model/documents.js';
import { labelName } from '../../model/labels.js';
import { trackName } from '../../model/track_name.js';
import { h, setText } from '../dom.js';
import { moment } from '../../model/format.js';
import { createVersionComparison } from './two_versions.js';

/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {import('../../types.js').Label} Label */
/** @typedef {import('../../editing/conflict_plan.js').Last} Last */

/** @type {Record<TrackDoc['review'], string>} */
const REVIEW_TEXTS = { open: 'not reviewed', accepted: 'accepted', rejected: 'false positive', needs_work: 'needs work' };

/**
 * A version of a track as rows for comparison.
 *
 * @param {TrackDoc|undefined} doc
 * @param {readonly Label[]} labels
 * @returns {Record<string, string>}
 */
export function describeVersion(doc, labels) {
  if (!doc) return { State: 'not there' };
  const name = doc.class_id === null ? 'as read by the engine' : labelName(labels, doc.class_id);
  const keys = Object.keys(doc.keys)
    .map(Number)
    .sort((a, b) => a - b);
  return {
    State: doc.merged_into ? `merged into ${trackName(doc.merged_into)}` : doc.gone ? 'deleted' : REVIEW_TEXTS[verdictOf(doc)],
    Label: name,
    Ignored: doc.ignore ? 'yes' : 'no',
    Frames: doc.segments.map(({ first, last }) => `${first}–${last}`).join(', ') || 'only drawn boxes',
    'Key frames': keys.length === 0 ? 'none' : keys.length > 8 ? `${keys.length}: ${keys[0]} … ${keys[keys.length - 1]}` : keys.join(', '),
    Notes: doc.notes.length === 0 ? 'none' : doc.notes.map((note) => `${note.author}: ${note.text}`).join('; '),
  };
}

/** Maximum number of boxes shown of each version. */
const MAX_BOXES = 6;

/**
 * Rows for the key frames in which two versions differ.
 *
 * @param {TrackDoc|undefined} savedDoc
 * @param {TrackDoc|undefined} ownDoc
 * @returns {[string, string, string][]} name, saved value, own value
 */
export function differingKeyFrames(savedDoc, ownDoc) {
  const frames = [...new Set([savedDoc, ownDoc].flatMap((doc) => Object.keys(doc?.keys ?? {}).map(Number)))].sort((a, b) => a - b);
  /** @type {[string, string, string][]} */
  const rows = frames.map((frame) => [`Frame ${frame}`, keyText(savedDoc, frame), keyText(ownDoc, frame)]);
  const differingRows = rows.filter(([, savedText, ownText]) => savedText !== ownText);
  const hiddenCount = differingRows.length - MAX_BOXES;
  return hiddenCount > 0
    ? [...differingRows.slice(0, MAX_BOXES), ['More frames', `${hiddenCount} differ`, `${hiddenCount} differ`]]
    : differingRows;
}

/** @param {TrackDoc|undefined} doc @param {number} frame */
function keyText(doc, frame) {
  const key = doc?.keys[frame];
  if (key === undefined) return 'no key frame';
  const box = key.box === null ? 'the engine’s box' : `${key.box.map((edge) => Math.round(edge * 10) / 10).join(', ')}`;
  return [
    box,
    key.occluded && 'occluded',
    key.outside && 'outside',
    key.interpolate && 'interpolated on',
    key.class_id !== null && key.class_id !== undefined && 'its own class',
  ]
    .filter(Boolean)
    .join('; ');
}

/**
 * Sentences about the changes of the tracks and the consequences for the edits.
 *
 * @param {Pick<import('../../editing/conflict_plan.js').Plan, 'moved'|'lost'>} plan
 * @param {Record<string, Last>} others                             last saved change, by track
 * @param {(key: string) => string} nameOf                          maps a key to the track's name
 * @param {(time: string) => string} [when]
 * @returns {string[]}
 */
export function describeConflict({ moved, lost }, others, nameOf, when = moment) {
  const savedChanges = Object.entries(others).map(
    ([key, { author, time, name, frame }]) => `${author} changed track ${nameOf(key)} on ${when(time)}: ${describeUndone(name, frame)}.`,
  );
  const movedTexts = moved.map(({ key, into }) =>
    into === null
      ? `Track ${nameOf(key)} was deleted: “Keep mine” restores it.`
      : `Track ${nameOf(key)} was merged into ${nameOf(into)}: “Keep mine” makes your change there.`,
  );
  return [...savedChanges, ...movedTexts, ...lost.map(({ name, why }) => `“${commandName(name)}” cannot be kept. ${why}`)];
}

/** @type {import('./index.js').CreateDialog<'conflict'>} */
export function conflictDialog({ app, data, close }) {
  const { labels, review } = app.store.get();
  const { saved, mine: ownDocs, others } = data;
  const docs = { ...review?.docs, ...Object.fromEntries(saved.map((doc) => [doc.key, doc])) };
  // the dialog opens in the middle of work: a key that was meant for the picture must not choose
  const introText = h(
    'p.dialog-intro',
    { tabIndex: -1 },
    'Another page saved a change of this track after you loaded it. Nothing is overwritten until you choose.',
  );
  const error = h('p.field-error', { role: 'alert', hidden: true });
  const takeSavedButton = h('button.btn', { onclick: () => runAction(data.takeTheirs) }, 'Take the saved version');
  const keepOwnButton = h(
    'button.btn.btn-primary',
    { disabled: ownDocs.length === 0, onclick: () => runAction(data.keepMine) },
    'Keep mine',
  );

  /** @param {(() => unknown)|undefined} run */
  async function runAction(run) {
    try {
      await run?.();
      close();
    } catch (thrown) {
      error.hidden = false;
      setText(error, errorMessage(thrown));
    }
  }

  return {
    title: 'This track was changed in the meantime',
    size: 'middle',
    focus: introText,
    body: h(
      'div.stack',
      introText,
      ...describeConflict(data, others, (key) => trackName(key, docs[key])).map((text) => h('p', withTrackNames(text, docs))),
      ...ownDocs.flatMap((doc) => {
        const savedDoc = saved.find(({ key }) => key === doc.key);
        return [versionTable(doc.key, savedDoc, doc, labels), createVersionComparison(app, review, savedDoc, doc)];
      }),
      h('p.muted.small', '“Keep mine” applies your change on top of the saved version. “Take the saved version” drops your change.'),
      error,
    ),
    footer: [h('button.btn.btn-quiet', { onclick: close }, 'Decide later'), h('span.grow'), takeSavedButton, keepOwnButton],
  };
}

/** @param {string} key @param {TrackDoc|undefined} savedDoc @param {TrackDoc|undefined} ownDoc @param {readonly Label[]} labels */
function versionTable(key, savedDoc, ownDoc, labels) {
  const [savedRows, ownRows] = [describeVersion(savedDoc, labels), describeVersion(ownDoc, labels)];
  const rows = [...new Set([...Object.keys(savedRows), ...Object.keys(ownRows)])];
  return h(
    'table.table.versions',
    h('caption', `Track ${trackName(key, savedDoc ?? ownDoc)}`),
    h(
      'thead',
      h(
        'tr',
        h('td'),
        h('th', { scope: 'col' }, `Saved${savedDoc ? ` (revision ${savedDoc.revision})` : ''}`),
        h('th', { scope: 'col' }, 'With your change'),
      ),
    ),
    h(
      'tbody',
      ...rows.map((row) =>
        h(
          'tr',
          { class: savedRows[row] === ownRows[row] ? '' : 'differs' },
          h('th', { scope: 'row' }, row),
          h('td', savedRows[row] ?? '–'),
          h('td', ownRows[row] ?? '–'),
        ),
      ),
      ...differingKeyFrames(savedDoc, ownDoc).map(([name, savedText, ownText]) =>
        h('tr.differs', h('th', { scope: 'row' }, name), h('td', savedText), h('td', ownText)),
      ),
    ),
  );
}

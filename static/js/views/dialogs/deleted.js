// @ts-check
/** Tracks that anybody has deleted in this run, with buttons to restore them. */

import { deletedTracks, lastEdits, exampleFrame } from '../../model/deleted.js';
import { labelOf } from '../../model/effective.js';
import { labelName, labelFor } from '../../model/labels.js';
import { trackName } from '../../model/track_name.js';
import { seek, select } from '../../store/actions/review.js';
import { fill, h } from '../dom.js';
import { frameSpan, moment } from '../../model/format.js';
import { pictureThatMayMiss, showPicture } from '../pictures.js';

/** Maximum number of log rows in one answer; an answer with fewer is the last. */
const PAGE = 1000;
/** px */
const PICTURE = 96;

/**
 * @param {import('./layer.js').Setup<'deleted'>} setup
 * @returns {import('./layer.js').Content}
 */
export function deletedDialog({ app, close, signal }) {
  const { store } = app;
  /** @type {Map<string, import('../../model/deleted.js').LastEdit>} */
  let said = new Map();
  let read = 0;
  const list = h('ul.made-list', { 'aria-label': 'Deleted tracks' });
  const done = h('button.btn.btn-primary', { onclick: close }, 'Close');

  /** @param {string} key @param {number} frame */
  function restore(key, frame) {
    if (!app.edit({ name: 'restore_track', key, frame })) return;
    store.dispatch((state) => select(seek(state, frame), key));
    done.focus();
  }

  function show() {
    const { review, labels } = store.get();
    const tracks = review?.tracks ?? null;
    /** @param {number} track */
    const columnOf = (track) => tracks?.id.indexOf(track) ?? -1;
    const found = review ? deletedTracks(review.docs, (track) => tracks?.last[columnOf(track)] ?? null) : [];
    fill(
      list,
      ...found.map(({ doc, first, last }) => {
        const name = trackName(doc.key, doc);
        const label = labelOf(doc, (track) => tracks?.class_id[columnOf(track)] ?? null);
        const text = labelName(labels, label);
        const by = said.get(doc.key);
        return h(
          'li.made',
          picture(doc, last, labelFor(labels, label)?.picture ?? undefined),
          h(
            'div.stack.made-text',
            h('strong', `Track ${name}`),
            h('span.muted.small', `${text} · ${first === last ? 'frame' : 'frames'} ${frameSpan(first, last)}`),
            h('span.muted.small', by ? `deleted by ${by.author} · ${moment(by.time)}` : '\u00a0'),
          ),
          h(
            'div.row.made-actions',
            h('button.btn.btn-small', { 'aria-label': `Restore track ${name}`, onclick: () => restore(doc.key, first) }, 'Restore'),
          ),
        );
      }),
    );
    list.hidden = found.length === 0;
    none.hidden = found.length > 0;
  }

  /**
   * The engine's crop of the track, else the picture of its class.
   *
   * @param {import('../../types.js').TrackDoc} doc
   * @param {number} last
   * @param {string|undefined} drawn
   */
  function picture(doc, last, drawn) {
    const from = exampleFrame(doc, last);
    const run = store.get().review?.run;
    const instead = () => showPicture(image, drawn);
    const image = pictureThatMayMiss({ class: 'deleted-picture', loading: 'lazy', decoding: 'async' });
    if (from && run) {
      image.addEventListener('error', instead, { once: true, signal });
      showPicture(image, app.api.cropUrl(run.id, from.track, from.frame, PICTURE));
    } else instead();
    return image;
  }

  /** Read the log from the last known row. The list also works without it. */
  async function readLog() {
    const run = store.get().review?.run;
    for (let rows = PAGE; run && rows === PAGE;) {
      const { edits } = await app.api.edits(run.id, read, { signal });
      rows = edits.length;
      read = edits.at(-1)?.seq ?? read;
      said = lastEdits(said, edits);
    }
    show();
  }
  let reading = Promise.resolve();
  const readOn = () => {
    reading = reading.then(readLog).catch(() => undefined);
  };

  const none = h('p.muted', 'No track is deleted now.');
  show();
  readOn();
  let docs = store.get().review?.docs;
  return {
    update({ review }) {
      if (review?.docs === docs) return; // a track was deleted or restored, here or in another page
      docs = review?.docs;
      show();
      readOn();
    },
    title: 'Deleted tracks',
    size: 'narrow',
    focus: done,
    footer: [done],
    body: h('div.stack', h('p.muted', 'A restored track is as it was before. To restore merged tracks, undo the merge.'), list, none),
  };
}

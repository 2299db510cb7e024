// @ts-check
/** Tracks that anybody has deleted in this run, with buttons to restore them. */

import { deletedTracks, lastEdits, exampleFrame } from '../../model/deleted.js';
import { labelOf } from '../../model/effective.js';
import { labelName, labelFor } from '../../model/labels.js';
import { trackName } from '../../model/track_name.js';
import { seek, select } from '../../store/actions/review.js';
import { fill, h } from '../dom.js';
import { frameSpan, moment } from '../../model/format.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';

/** Maximum number of log rows in one answer; an answer with fewer is the last. */
const LOG_PAGE_ROWS = 1000;
/** px */
const PICTURE_SIZE_PX = 96;

/** @type {import('./index.js').CreateDialog<'deleted'>} */
export function deletedDialog({ app, close, signal }) {
  const { store } = app;
  /** @type {Map<string, import('../../model/deleted.js').LastEdit>} */ let lastEditByTrack = new Map();
  let lastSeq = 0;
  const list = h('ul.made-list', { 'aria-label': 'Deleted tracks' });
  const closeButton = h('button.btn.btn-primary', { onclick: close }, 'Close');

  /** @param {string} key @param {number} frame */
  function restore(key, frame) {
    if (!app.edit({ name: 'restore_track', key, frame })) return;
    store.dispatch((state) => select(seek(state, frame), key));
    closeButton.focus();
  }

  function show() {
    const { review, labels } = store.get();
    const tracks = review?.tracks ?? null;
    /** @param {number} track */
    const columnOf = (track) => tracks?.id.indexOf(track) ?? -1;
    const deleted = review ? deletedTracks(review.docs, (track) => tracks?.last[columnOf(track)] ?? null) : [];
    fill(
      list,
      ...deleted.map(({ doc, first, last }) => {
        const name = trackName(doc.key, doc);
        const label = labelOf(doc, (track) => tracks?.class_id[columnOf(track)] ?? null);
        const text = labelName(labels, label);
        const edit = lastEditByTrack.get(doc.key);
        return h(
          'li.made',
          picture(doc, last, labelFor(labels, label)?.picture ?? undefined),
          h(
            'div.stack.made-text',
            h('strong', `Track ${name}`),
            h('span.muted.small', `${text} · ${first === last ? 'frame' : 'frames'} ${frameSpan(first, last)}`),
            h('span.muted.small', edit ? `deleted by ${edit.author} · ${moment(edit.time)}` : '\u00a0'),
          ),
          h(
            'div.row.made-actions',
            h('button.btn.btn-small', { 'aria-label': `Restore track ${name}`, onclick: () => restore(doc.key, first) }, 'Restore'),
          ),
        );
      }),
    );
    list.hidden = deleted.length === 0;
    emptyText.hidden = deleted.length > 0;
  }

  /**
   * The engine's crop of the track, else the picture of its class.
   *
   * @param {import('../../types.js').TrackDoc} doc
   * @param {number} last
   * @param {string|undefined} labelPicture
   */
  function picture(doc, last, labelPicture) {
    const from = exampleFrame(doc, last);
    const run = store.get().review?.run;
    const showLabelPicture = () => setImageSource(image, labelPicture);
    const image = imageWithPlaceholder({ class: 'deleted-picture', loading: 'lazy', decoding: 'async' });
    if (from && run) {
      image.addEventListener('error', showLabelPicture, { once: true, signal });
      setImageSource(image, app.api.cropUrl(run.id, from.track, from.frame, PICTURE_SIZE_PX));
    } else showLabelPicture();
    return image;
  }

  /** Read the log from the last known row. The list also works without it. */
  async function readLog() {
    const run = store.get().review?.run;
    for (let rows = LOG_PAGE_ROWS; run && rows === LOG_PAGE_ROWS;) {
      const { edits } = await app.api.edits(run.id, lastSeq, { signal });
      rows = edits.length;
      lastSeq = edits.at(-1)?.seq ?? lastSeq;
      lastEditByTrack = lastEdits(lastEditByTrack, edits);
    }
    show();
  }
  let logRead = Promise.resolve();
  const queueLogRead = () => {
    logRead = logRead.then(readLog).catch(() => undefined);
  };

  const emptyText = h('p.muted', 'No track is deleted now.');
  show();
  queueLogRead();
  let docs = store.get().review?.docs;
  return {
    update({ review }) {
      if (review?.docs === docs) return; // a track was deleted or restored, here or in another page
      docs = review?.docs;
      show();
      queueLogRead();
    },
    title: 'Deleted tracks',
    size: 'narrow',
    focus: closeButton,
    footer: [closeButton],
    body: h('div.stack', h('p.muted', 'A restored track is as it was before. To restore merged tracks, undo the merge.'), list, emptyText),
  };
}

// @ts-check
/**
 * Buttons for the labels pinned to digits, and a button that makes a crop of an accepted track the picture of its
 * label.
 */

import { sentence } from '../../api/errors.js';
import { labelSetKey } from '../../editing/label_sets.js';
import { labelFor, offeredLabels } from '../../model/labels.js';
import { setPinnedLabel } from '../../operations/verdicts.js';
import { shownTrack } from '../../review/shown_tracks.js';
import { fill, h } from '../dom.js';
import { icon } from '../icons.js';
import { pngOf } from '../label_picture.js';
import { pictureThatMayMiss } from '../pictures.js';
import { toast } from '../../core/toast.js';

/** @typedef {import('../../types.js').Label} Label */

/** @param {import('../../page-types.js').App} app @param {AbortSignal} signal */
export function createPinned(app, signal) {
  const strip = h('div.pinned-labels', { role: 'group', 'aria-label': 'Pinned labels' });
  const cut = h(
    'button.btn.btn-small',
    { title: 'Use the box in this frame as the picture of the label, which has none' },
    icon('box'),
    'Use as the label’s picture',
  );
  const element = h('div.inspector-pinned', strip, cut);
  /** @type {Label|null} */ let label = null;
  /** @type {readonly Label[]|null} */ let listed = null;

  cut.addEventListener('click', () => void cutOut(), { signal });

  async function cutOut() {
    const { review } = app.store.get();
    const shown = review?.selected ? shownTrack(review, review.selected) : null;
    const [given, set] = [label, labelSetKey(app.store.get())];
    if (!review || !given) return;
    if (!shown) {
      toast('The track has no box in this frame. Go to a frame where the sign is clear.');
      return;
    }
    cut.disabled = true;
    try {
      const { blob } = await app.api.frame(review.video.id, review.frame, { signal });
      toast((await app.labels.change({ type: 'picture', id: given.id, png: await pngOf(blob, shown.box) }, set)).sentence, {
        tone: 'good',
      });
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad' });
    } finally {
      cut.disabled = false;
    }
  }

  /** @param {Label} one */
  const button = (one) =>
    h(
      'button.btn.btn-small',
      { title: `${one.name} (Ctrl+${one.pinned})`, onclick: () => setPinnedLabel(app, String(one.pinned)) },
      one.picture && pictureThatMayMiss({ class: 'pinned-picture', src: one.picture }),
      h('span.truncate', { dir: 'auto' }, one.short || one.name.slice(0, 12)),
      h('kbd', one.pinned),
    );

  return {
    element,
    /** @param {import('./index.js').Inspected} inspected */
    update({ state, entry }) {
      if (state.labels !== listed) {
        listed = state.labels;
        const pinned = offeredLabels(listed)
          .filter((one) => one.pinned !== null)
          .sort((a, b) => Number(a.pinned) - Number(b.pinned));
        fill(strip, ...pinned.map(button));
        strip.hidden = pinned.length === 0;
      }
      label = labelFor(state.labels, entry.class_id) ?? null;
      cut.hidden = label === null || label.picture !== null || entry.review !== 'accepted';
    },
  };
}

// @ts-check
/**
 * Buttons for the labels pinned to digits, and a button that makes a crop of an accepted track the picture of its
 * label.
 */

import { errorMessage } from '../../api/errors.js';
import { labelSetKey } from '../../editing/label_sets.js';
import { labelFor, offeredLabels } from '../../model/labels.js';
import { setPinnedLabel } from '../../operations/verdicts.js';
import { shownTrack } from '../../review/shown_tracks.js';
import { fill, h } from '../dom.js';
import { icon } from '../icons.js';
import { toPngBase64 } from '../label_picture.js';
import { imageWithPlaceholder } from '../images.js';
import { toast } from '../../core/toast.js';

/** @typedef {import('../../types.js').Label} Label */

/** @param {import('../../page-types.js').App} app @param {AbortSignal} signal */
export function createPinned(app, signal) {
  const strip = h('div.pinned-labels', { role: 'group', 'aria-label': 'Pinned labels' });
  const pictureButton = h(
    'button.btn.btn-small',
    { title: 'Use the box in this frame as the picture of the label, which has none' },
    icon('box'),
    'Use as the label’s picture',
  );
  const element = h('div.inspector-pinned', strip, pictureButton);
  /** @type {Label|null} */ let label = null;
  /** @type {readonly Label[]|null} */ let shownLabels = null;

  pictureButton.addEventListener('click', () => void usePicture());

  async function usePicture() {
    const { review } = app.store.get();
    const shown = review?.selected ? shownTrack(review, review.selected) : null;
    const [currentLabel, set] = [label, labelSetKey(app.store.get())];
    if (!review || !currentLabel) return;
    if (!shown) {
      toast('The track has no box in this frame. Go to a frame where the sign is clear.');
      return;
    }
    pictureButton.disabled = true;
    try {
      const { blob } = await app.api.frame(review.video.id, review.frame, { signal });
      toast((await app.labels.change({ type: 'picture', id: currentLabel.id, png: await toPngBase64(blob, shown.box) }, set)).sentence, {
        tone: 'good',
      });
    } catch (thrown) {
      if (!signal.aborted) toast(errorMessage(thrown), { tone: 'bad' });
    } finally {
      pictureButton.disabled = false;
    }
  }

  /** @param {Label} pinnedLabel */
  const button = (pinnedLabel) =>
    h(
      'button.btn.btn-small',
      { title: `${pinnedLabel.name} (Ctrl+${pinnedLabel.pinned})`, onclick: () => setPinnedLabel(app, String(pinnedLabel.pinned)) },
      pinnedLabel.picture && imageWithPlaceholder({ class: 'pinned-picture', src: pinnedLabel.picture }),
      h('span.truncate', { dir: 'auto' }, pinnedLabel.short || pinnedLabel.name.slice(0, 12)),
      h('kbd', pinnedLabel.pinned),
    );

  return {
    element,
    /** @param {import('./index.js').Inspected} inspected */
    update({ state, entry }) {
      if (state.labels !== shownLabels) {
        shownLabels = state.labels;
        const pinned = offeredLabels(shownLabels)
          .filter((one) => one.pinned !== null)
          .sort((a, b) => Number(a.pinned) - Number(b.pinned));
        fill(strip, ...pinned.map(button));
        strip.hidden = pinned.length === 0;
      }
      label = labelFor(state.labels, entry.class_id) ?? null;
      pictureButton.hidden = label === null || label.picture !== null || entry.review !== 'accepted';
    },
  };
}

// @ts-check
/** Choose the label set of a video: the library's default, or its own. */

import { errorMessage } from '../../api/errors.js';
import { putVideo } from '../../store/actions/page.js';
import { h, selectInput, setText } from '../dom.js';
import { field } from './fields.js';

/** @param {import('../../page-types.js').App} app @param {import('../../types.js').Video} video @param {AbortSignal} signal */
export function createLabelSetField(app, video, signal) {
  const { store, api } = app;
  const sets = store.get().labelSets ?? [];
  const defaultSet = sets.find((set) => set.default);
  const errorText = h('p.field-error', { role: 'alert' });
  let currentKey = video.label_set ?? '';
  const select = selectInput(
    { id: 'video-labels', onchange: () => void applySet() },
    [['', `the library’s: ${defaultSet?.name ?? '…'}`], ...sets.map(({ key, name }) => /** @type {const} */ ([key, name]))],
    currentKey,
  );

  async function applySet() {
    select.disabled = true;
    setText(errorText, '');
    try {
      await api.useLabelSet(video.id, select.value || null, { signal });
      currentKey = select.value;
      await app.load(() => api.video(video.id, { signal }), putVideo);
      await app.labels.reload();
    } catch (thrown) {
      if (signal.aborted) return;
      select.value = currentKey;
      setText(errorText, errorMessage(thrown));
    } finally {
      select.disabled = false;
    }
  }

  return h('div.stack', field('Label set', select), errorText);
}

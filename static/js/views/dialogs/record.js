// @ts-check
/** Make a recording of a range of frames for the Rerun viewer. */

import { errorMessage } from '../../api/errors.js';
import { putOutput } from '../../store/actions/page.js';
import { changeReview } from '../../store/actions/review.js';
import { h, setText } from '../dom.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';
import { createFrameRange } from './frame_range.js';

const INITIAL_FRAMES = 300;
const MAX_FRAMES = 20_000;

/** @type {import('./index.js').CreateDialog<'record'>} */
export function recordDialog({ app, close, signal }) {
  const review = app.store.get().review;
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit' }, icon('film'), 'Record');
  const frameRange = createFrameRange(review, {
    id: 'record',
    initialLength: INITIAL_FRAMES,
    maxLength: MAX_FRAMES,
    onChange: (message) => {
      setText(errorText, message);
      submitButton.disabled = message !== '';
    },
  });

  async function submit() {
    const range = frameRange.value();
    if ('error' in range || !review?.run) return;
    submitButton.disabled = true;
    try {
      const frame = Math.min(range.stop - 1, Math.max(range.first, review.frame));
      const { id } = review.run;
      await app.load(
        () => app.api.record(id, { ...range, frame, track: review.selected }, { signal }),
        (state, output) => putOutput(changeReview(state, { beside: null }), output),
      );
      // The view lists recordings when it opens, so an open view is closed and opened again.
      requestAnimationFrame(() => requestAnimationFrame(() => app.store.dispatch(changeReview, { beside: 'recording' })));
      toast('The recording is ready and opens beside the picture.', { tone: 'good' });
      close();
    } catch (thrown) {
      if (signal.aborted) return;
      setText(errorText, errorMessage(thrown));
      submitButton.disabled = false;
    }
  }

  frameRange.validate();
  return {
    title: 'Record for the Rerun viewer',
    size: 'narrow',
    submit,
    focus: frameRange.focus,
    body: h(
      'div.stack',
      h(
        'p.muted',
        'Pictures, boxes, the gate’s factors, votes and events of these frames in one .rrd file. View it beside the picture, or download it for a separate viewer.',
      ),
      frameRange.element,
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Cancel'), submitButton],
  };
}

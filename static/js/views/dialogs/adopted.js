// @ts-check
/** Carries another run's corrections over to this one, and reports the outcome. */

import { errorMessage } from '../../api/errors.js';
import { trackName } from '../../model/track_name.js';
import { endOffer } from '../../review/earlier_corrections.js';
import { changeReview, seek, select } from '../../store/actions/review.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { authorName } from '../../core/preferences.js';
import { runName } from '../../model/describe_run.js';

/** @type {import('./index.js').CreateDialog<'adopted'>} */
export function adoptedDialog({ app, data, close, signal }) {
  const text = h(
    'p',
    { role: 'status' },
    `Each corrected track of “${runName(data.from)}” is matched to a track of “${runName(data.to)}” by its boxes.`,
  );
  const error = h('p.field-error', { role: 'alert' });
  const list = h('ul.stack');
  const cancelButton = h('button.btn', { onclick: close }, 'Cancel');
  const submitButton = h('button.btn.btn-primary', { type: 'submit' }, 'Carry the corrections over');
  let isDone = false;

  /** @param {{key: string, reason: string, frame: number}} conflict */
  const row = ({ key, reason, frame }) =>
    h(
      'li.row',
      h(
        'button.btn.btn-small',
        {
          onclick: () => {
            close();
            app.store.dispatch((state) => select(seek(state, frame), null));
            app.loader.showSecond(data.from.id);
            app.store.dispatch(changeReview, { playing: false });
          },
        },
        `Frame ${frame}`,
      ),
      h('span.grow', `Track ${trackName(key)}: ${reason}`),
    );

  async function submit() {
    if (isDone) {
      close();
      return;
    }
    submitButton.disabled = true;
    try {
      const outcome = await app.api.adopt(data.to.id, data.from.id, authorName(app.store.get().session), { signal });
      await app.editor.refresh();
      endOffer(app, data.to.id, data.from.id);
      isDone = true;
      cancelButton.hidden = true;
      submitButton.disabled = false;
      submitButton.textContent = 'Close';
      setText(
        text,
        `${plural(outcome.kept.length, 'track')} kept, ${outcome.not_needed.length} not needed because the run agrees, ${plural(outcome.conflicts.length, 'conflict')}${outcome.conflicts.length ? ':' : '.'}`,
      );
      list.replaceChildren(...outcome.conflicts.map(row));
    } catch (thrown) {
      if (signal.aborted) return;
      submitButton.disabled = false;
      setText(error, errorMessage(thrown));
    }
  }

  if (data.now) void submit();
  return {
    title: 'Carry corrections over to this run',
    size: 'middle',
    body: h('div.stack', text, error, list),
    footer: [cancelButton, submitButton],
    submit,
    focus: submitButton,
  };
}

// @ts-check
/** Carries another run's corrections over to this one, and reports the outcome. */

import { sentence } from '../../api/errors.js';
import { trackName } from '../../model/track_name.js';
import { endOffer } from '../../review/earlier_corrections.js';
import { changeReview, seek, select } from '../../store/actions/review.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { authorName } from '../../core/preferences.js';
import { runName } from '../../model/describe_run.js';

/**
 * @param {import('./layer.js').Setup<'adopted'>} setup
 * @returns {import('./layer.js').Content}
 */
export function adoptedDialog({ app, data, close, signal }) {
  const text = h(
    'p',
    { role: 'status' },
    `Each corrected track of “${runName(data.from)}” is matched to a track of “${runName(data.to)}” by its boxes.`,
  );
  const error = h('p.field-error', { role: 'alert' });
  const list = h('ul.stack');
  const cancel = h('button.btn', { onclick: close }, 'Cancel');
  const go = h('button.btn.btn-primary', { type: 'submit' }, 'Carry the corrections over');
  let done = false;

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
    if (done) {
      close();
      return;
    }
    go.disabled = true;
    try {
      const found = await app.api.adopt(data.to.id, data.from.id, authorName(app.store.get().session), { signal });
      await app.editor.refresh();
      endOffer(app, data.to.id, data.from.id);
      done = true;
      cancel.hidden = true;
      go.disabled = false;
      go.textContent = 'Close';
      setText(
        text,
        `${plural(found.kept.length, 'track')} kept, ${found.not_needed.length} not needed because the run agrees, ${plural(found.conflicts.length, 'conflict')}${found.conflicts.length ? ':' : '.'}`,
      );
      list.replaceChildren(...found.conflicts.map(row));
    } catch (thrown) {
      if (signal.aborted) return;
      go.disabled = false;
      setText(error, sentence(thrown));
    }
  }

  if (data.now) void submit();
  return {
    title: 'Carry corrections over to this run',
    size: 'middle',
    body: h('div.stack', text, error, list),
    footer: [cancel, go],
    submit,
    focus: go,
  };
}

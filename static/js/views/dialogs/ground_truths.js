// @ts-check
/** The ground truths of a video: show or remove one. */

import { errorMessage } from '../../api/errors.js';
import { openDialog } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { emptyState } from '../placeholders.js';
import { plural } from '../../model/format.js';
import { icon, iconButton } from '../icons.js';
import { toast } from '../../core/toast.js';

/** @type {import('./index.js').CreateDialog<'ground-truths'>} */
export function groundTruthsDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const list = h('ul.made-list', { 'aria-label': 'Ground truths', hidden: true });
  const emptyElement = h(
    'div',
    { hidden: true },
    emptyState({
      icon: 'check',
      title: 'No ground truth yet',
      text: 'Import boxes that are known to be right, to show them with runs and compare runs with them.',
    }),
  );
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const importButton = h(
    'button.btn.btn-primary',
    { onclick: () => store.dispatch(openDialog, { kind: 'import', data: { video: data.video, as: 'truth' } }) },
    icon('add'),
    'Import ground truth',
  );

  async function load() {
    try {
      const groundTruths = await api.groundTruths(data.video, { signal });
      const isOpen = store.get().review?.video.id === data.video;
      emptyElement.hidden = groundTruths.length > 0;
      list.hidden = groundTruths.length === 0;
      fill(
        list,
        ...groundTruths.map((truth) =>
          h(
            'li.made',
            h('div.stack.made-text', h('strong.truncate', truth.name), h('span.muted.small', plural(truth.count, 'box', 'boxes'))),
            h(
              'div.row.made-actions',
              isOpen &&
                h(
                  'button.btn.btn-small',
                  {
                    'aria-label': `Show ${truth.name}`,
                    onclick: () => {
                      app.loader.showTruth(truth.id);
                      close();
                    },
                  },
                  'Show',
                ),
              iconButton('delete', `Delete ${truth.name}`, () => confirmRemoval(truth), 'Delete …'),
            ),
          ),
        ),
      );
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  /** @param {import('../../api/ground_truths.js').GroundTruth} truth */
  function confirmRemoval(truth) {
    store.dispatch(openDialog, {
      kind: 'confirm',
      data: {
        title: 'Delete this ground truth?',
        confirm: 'Delete',
        danger: true,
        text: `${truth.name} with ${plural(truth.count, 'box', 'boxes')} will be deleted. Runs and corrections stay.`,
        run: async () => {
          await api.removeTruth(truth.id);
          if (store.get().review?.truthId === truth.id) app.loader.showTruth(null);
          toast(`${truth.name} was deleted.`);
        },
      },
    });
  }

  void load();
  return {
    title: 'Ground truths',
    size: 'narrow',
    focus: importButton,
    body: h('div.stack', list, emptyElement),
    footer: [errorText, h('button.btn', { onclick: close }, 'Close'), importButton],
  };
}

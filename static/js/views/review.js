// @ts-check
/** The review screen: toolbar, picture, right column and lanes, with movable dividers between them. */

import { isOpening, reviewNotice } from '../model/review_notice.js';
import { formatRoute } from '../model/route.js';
import { openDialog } from '../store/actions/page.js';
import { createViewerPanel } from './viewer_panel.js';
import { h, setAttribute } from './dom.js';
import { acceptFileDrops } from './file_drop.js';
import { emptyState, loadingState } from './placeholders.js';
import { icon } from './icons.js';
import { createInspector } from './inspector/index.js';
import { createLanes } from './lanes/index.js';
import { createPicture } from './picture/index.js';
import { createQueue } from './queue/index.js';
import { createSplitter } from './splitter.js';
import { createTabs } from './tabs.js';
import { createToolbar } from './toolbar.js';
import { createAssignmentStrip } from './assignment_strip.js';

/** Height of a window below which the lanes need a larger share, px. */
const LOW_WINDOW_PX = 820;

/** @type {import('../page-types.js').CreateView} */
export function createReview(app) {
  const lifetime = new AbortController();
  const toolbar = createToolbar(app);
  const assignmentStrip = createAssignmentStrip(app);
  const picture = createPicture(app);
  const lanes = createLanes(app);
  const sideTabs = createTabs({
    label: 'Track details and queue',
    name: 'review.tab',
    sideBySideQuery: '(min-width: 1600px)',
    tabs: [
      { id: 'queue', label: 'Queue', view: createQueue(app) },
      { id: 'inspector', label: 'Inspector', view: createInspector(app) },
    ],
  });
  const top = h('div.review-top');
  const grid = h('div.review-grid');
  const pictures = h('div.review-pictures');
  const viewerPanel = createViewerPanel(app, (large) => grid.classList.toggle('beside-large', large));
  const viewerSplitter = createSplitter(pictures, '--beside', 'vertical', {
    label: 'Width of the view beside the picture',
    name: 'review.beside',
    initial: 55,
    low: 25,
    high: 80,
  });
  // one column and two columns need different widths: each is remembered
  const oneColumn = { label: 'Width of the right column', name: 'review.side', initial: 28, low: 18, high: 50 };
  const twoColumns = { label: 'Width of queue and inspector', name: 'review.side.two', initial: 36, low: 24, high: 60 };
  const sideSplitters = [
    createSplitter(top, '--side-one', 'vertical', oneColumn),
    createSplitter(top, '--side-two', 'vertical', twoColumns),
  ];
  sideSplitters.forEach((splitter, index) => splitter.classList.add(index === 0 ? 'line-one' : 'line-two'));
  pictures.append(h('section.review-picture', { 'aria-label': 'Picture' }, picture.element), viewerSplitter, viewerPanel.element);
  top.append(pictures, ...sideSplitters, h('section.review-side', { 'aria-label': 'Track details and queue' }, sideTabs.element));
  const foldedLanes = { label: 'Height of the folded lanes', name: 'review.lanes.folded', initial: 27.45, low: 12, high: 65 };
  const allLanes = {
    label: 'Height of the lanes',
    name: 'review.lanes',
    initial: innerHeight <= LOW_WINDOW_PX ? 43 : 38,
    low: 12,
    high: 65,
  };
  const laneSplitters = [
    createSplitter(grid, '--lanes-folded', 'horizontal', foldedLanes),
    createSplitter(grid, '--lanes', 'horizontal', allLanes),
  ];
  grid.append(top, ...laneSplitters, h('section.review-lanes', { 'aria-label': 'Time lanes' }, lanes.element));
  const notice = h('div.review-notice', loadingState('Opening the review', { signal: lifetime.signal }));
  const element = h(
    'div.review',
    h('h1.visually-hidden', 'Review'),
    toolbar.element,
    assignmentStrip.element,
    grid,
    notice,
    h('div.drop-hint', { 'aria-hidden': 'true' }, icon('import'), h('span', 'Drop annotations to import them for this video')),
  );
  acceptFileDrops(element, ([file]) => {
    const { review } = app.store.get();
    if (file && review) app.store.dispatch(openDialog, { kind: 'import', data: { video: review.video.id, file } });
  });
  const parts = [toolbar, assignmentStrip, picture, viewerPanel, sideTabs, lanes];
  let noticeKind = 'waiting';

  /** @param {import('../state-types.js').State} state */
  function showNotice(state) {
    const kind = reviewNotice(state);
    grid.hidden = kind !== 'none';
    notice.hidden = kind === 'none';
    setAttribute(grid, 'aria-busy', String(isOpening(state)));
    if (kind === noticeKind) return;
    noticeKind = kind;
    if (kind === 'unknown') {
      notice.replaceChildren(
        emptyState({
          icon: 'film',
          title: 'This video is not in the library',
          text: 'It may have been removed, or the address belongs to another data folder.',
          actions: [h('a.btn.btn-primary', { href: '#/' }, 'Go to the library')],
        }),
      );
    } else if (kind === 'gone') {
      const video = state.review?.video.id ?? '';
      const others = (state.runs[video] ?? []).length > 0;
      notice.replaceChildren(
        emptyState({
          icon: 'run',
          title: 'This run no longer exists',
          text: 'It was removed, with its corrections.',
          actions: [
            h('a', { class: others ? 'btn' : 'btn btn-primary', href: '#/' }, 'Go to the library'),
            ...(others
              ? [
                  h(
                    'a.btn.btn-primary',
                    { href: formatRoute({ screen: 'review', video, run: null, frame: state.review?.frame ?? null, track: null }) },
                    'Open the newest run',
                  ),
                ]
              : []),
          ],
        }),
      );
    } else if (kind === 'waiting') {
      notice.replaceChildren(loadingState('Opening the review', { signal: lifetime.signal }));
    }
  }

  return {
    element,
    update(state) {
      showNotice(state);
      viewerSplitter.hidden = !state.review?.beside;
      const { folded } = state.lanesView;
      grid.classList.toggle('review-folded', folded);
      laneSplitters.forEach((splitter, index) => {
        splitter.hidden = folded !== (index === 0);
      });
      for (const part of parts) part.update(state);
    },
    destroy() {
      lifetime.abort();
      for (const view of [toolbar, picture, viewerPanel, sideTabs, lanes]) view.destroy();
    },
  };
}

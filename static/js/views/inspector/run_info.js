// @ts-check
/** Parameters and models of the run, folded. */

import { fill, h } from '../dom.js';
import { describeFocus } from '../../model/focus.js';
import { moment } from '../../model/format.js';
import { runInexact } from '../../model/describe_run.js';

export function createRunInfo() {
  const table = h('dl.facts');
  /** @type {import('../../types.js').Run|null} */ let shownRun = null;
  const element = h('details.inspector-section.inspector-run', h('summary', 'Run: parameters and models'), table);
  return {
    element,
    /** @param {import('../../types.js').Run|null} run */
    update(run) {
      if (run === shownRun) return;
      shownRun = run;
      element.hidden = run === null;
      if (run === null) return;
      const rows = [
        ['Preset', run.preset],
        ['Engine', run.engine_version],
        ['Made', moment(run.created)],
        ...Object.entries(run.parameters).map(([name, value]) => [name, typeof value === 'string' ? value : JSON.stringify(value)]),
        ...[runInexact(run)].filter((text) => text !== '').map((text) => ['Replay', text]),
        ...[describeFocus(run)].filter((text) => text !== null).map((text) => ['Focus of expansion', text]),
        ...Object.entries(run.models).map(([name, hash]) => [`Model ${name}`, hash]),
      ];
      fill(
        table,
        rows.flatMap(([name, value]) => [h('dt', name), h('dd.mono', { title: value }, value)]),
      );
    },
  };
}

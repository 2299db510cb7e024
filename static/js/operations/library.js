// @ts-check
/** Dialogs of the other screens, available everywhere. */

import { hasRole } from '../model/team.js';
import { openDialog } from '../store/actions/page.js';
import { operation } from './helpers.js';

/** @typedef {import('../page-types.js').Operation} Operation */

/** Whether the person may do more than their own work. @param {import('../state-types.js').State} state */
const available = ({ session }) => hasRole(session, 'reviewer');

/** @type {readonly [import('../state-types.js').Dialog, string, string, Operation['icon'], string][]} */
const DIALOGS = [
  [{ kind: 'add-video' }, 'Add videos from a folder …', 'Library', 'folder', 'Add videos from this machine'],
  [{ kind: 'run-queue' }, 'Run queue …', 'Library', 'sort', 'Running and waiting runs, and their order'],
  [{ kind: 'export' }, 'Export several videos …', 'Library', 'export', 'Annotations of one or several videos'],
  [{ kind: 'import-bundle' }, 'Open a bug bundle …', 'Library', 'bug', 'Take somebody’s bug bundle into the library'],
  [{ kind: 'retrain' }, 'Retrain …', 'Models', 'run', 'Make a new model version from corrections'],
];

/** @type {Operation[]} */
export const library = DIALOGS.map(([dialog, label, group, icon, tooltip]) =>
  operation({
    id: `open-${dialog.kind}`,
    label,
    keys: [],
    icon,
    group,
    tooltip,
    available,
    run: (app) => app.store.dispatch(openDialog, dialog),
  }),
);

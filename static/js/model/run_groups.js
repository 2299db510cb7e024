// @ts-check
/**
 * Groups runs: each what-if follows the run that it replays. Pure.
 *
 * @typedef {import('../types.js').Run} Run
 */

/**
 * @param {readonly Run[]} runs   newest first
 * @returns {{run: Run, whatifs: Run[]}[]} in the order of the runs; a what-if whose run is missing is a group of its own
 */
export function groupRuns(runs) {
  const below = new Map(runs.map(({ id }) => [id, /** @type {Run[]} */ ([])]));
  /** @type {Run[]} */
  const tops = [];
  for (const run of runs) {
    const siblings = run.kind === 'whatif' && run.parent_id !== null ? below.get(run.parent_id) : undefined;
    (siblings ?? tops).push(run);
  }
  return tops.map((run) => ({ run, whatifs: below.get(run.id) ?? [] }));
}

/**
 * The same as a flat list.
 *
 * @param {readonly Run[]} runs   newest first
 * @returns {{run: Run, under: boolean, whatifs: number}[]} under: a what-if below its run; whatifs: number of what-ifs below this run
 */
export function listRuns(runs) {
  return groupRuns(runs).flatMap(({ run, whatifs }) => [
    { run, under: false, whatifs: whatifs.length },
    ...whatifs.map((one) => ({ run: one, under: true, whatifs: 0 })),
  ]);
}

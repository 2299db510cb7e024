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
  const whatIfsOf = new Map(runs.map(({ id }) => [id, /** @type {Run[]} */ ([])]));
  /** @type {Run[]} */
  const groupedRuns = [];
  for (const run of runs) {
    const siblings = run.kind === 'whatif' && run.parent_id !== null ? whatIfsOf.get(run.parent_id) : undefined;
    (siblings ?? groupedRuns).push(run);
  }
  return groupedRuns.map((run) => ({ run, whatifs: whatIfsOf.get(run.id) ?? [] }));
}

/**
 * The same as a flat list.
 *
 * @param {readonly Run[]} runs   newest first
 * @returns {{run: Run, isWhatIf: boolean, whatifs: number}[]} isWhatIf: a what-if below its run; whatifs: number of what-ifs below this run
 */
export function listRuns(runs) {
  return groupRuns(runs).flatMap(({ run, whatifs }) => [
    { run, isWhatIf: false, whatifs: whatifs.length },
    ...whatifs.map((one) => ({ run: one, isWhatIf: true, whatifs: 0 })),
  ]);
}

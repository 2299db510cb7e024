// Written by `python -m tests.architecture.page_types` from the OpenAPI document of the server.
// Do not edit: change the model in app/, then run the command. static/js/types.js gives the types their short names.

export type paths = Record<string, never>;
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description An action of one person on tracks that were found. */
        ActionRequest: {
            action_id: string;
            author?: string | null;
            action: components["schemas"]["Judge"] | components["schemas"]["Ignore"] | components["schemas"]["Relabel"];
            tracks: components["schemas"]["WantedTrack"][];
        };
        /** @description A person's operations, newest first. */
        Activity: {
            worker: components["schemas"]["Worker"];
            done: components["schemas"]["Done"][];
            /** @description Request rows before this number for older operations; None: there are none. */
            more: number | null;
        };
        /** @description Make this frame a key frame with the displayed box. */
        AddKey: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "add_key";
            box: [
                number,
                number,
                number,
                number
            ];
        };
        /** @description Add a label; its key is made from the name if none is sent. */
        AddLabel: {
            /** @default  */
            short?: string;
            aliases?: string[];
            /**
             * @default other
             * @enum {string}
             */
            shape?: "triangle" | "inverted triangle" | "circle" | "octagon" | "diamond" | "rectangle" | "other";
            /**
             * @default other
             * @enum {string}
             */
            category?: "prohibitory" | "mandatory" | "danger" | "priority" | "information" | "direction" | "additional" | "other";
            attributes?: components["schemas"]["NewAttribute"][];
            size_mm?: number | null;
            mirror?: string | null;
            /**
             * @default sign
             * @enum {string}
             */
            teach?: "sign" | "background" | "ignore";
            colour?: string | null;
            pinned?: number | null;
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "add";
            name: string;
            key?: string | null;
            /**
             * @description a drawing that ships with tsr
             * @default
             */
            pictogram?: string;
        };
        /** @description Add a note to this frame. */
        AddNote: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "add_note";
            note_id: string;
            text: string;
        };
        /** @description An edit that could not be carried over. */
        AdoptConflict: {
            key: string;
            reason: string;
            frame: number;
        };
        /** @description Where the edits come from. */
        AdoptFrom: {
            from_run: string;
            author?: string | null;
        };
        /** @description Add the missing labels of another set. */
        AdoptSet: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "adopt";
            set: string;
        };
        /** @description Result of carrying the edits of another run over. */
        Adopted: {
            kept: string[];
            not_needed: string[];
            conflicts: components["schemas"]["AdoptConflict"][];
        };
        /** @description How often second answers equal the first. */
        Agreement: {
            name: string;
            looked: number;
            agreed: number;
            /** @description Lower end of the 95 % interval of the share. */
            low: number;
            high: number;
        };
        /** @description All corrections of a run. */
        Annotation: {
            /** @description Number of the newest operation. */
            seq: number;
            docs: components["schemas"]["TrackDoc"][];
            /** @description The operation that Ctrl+Z undoes for this author. */
            undo: components["schemas"]["Target"] | null;
            redo: components["schemas"]["Target"] | null;
        };
        /** @description Fields to change; omitted fields stay. */
        AssignmentChange: {
            revision: number;
            state?: ("assigned" | "in_review" | "returned" | "done") | null;
            comment?: string | null;
            person?: string | null;
        };
        /** @description One assignment; see ``Assignment`` in static/js/types.js. */
        AssignmentView: {
            id: number;
            video_id: string;
            video_name: string;
            person: string;
            first: number;
            stop: number | null;
            /** @enum {string} */
            state: "assigned" | "in_review" | "returned" | "done";
            comment: string;
            changed_by: string;
            revision: number;
            created: string;
            changed: string;
        };
        /** @description Some assignments. */
        Assignments: {
            assignments: components["schemas"]["AssignmentView"][];
        };
        /** @description A further property of a sign; see ``Attribute`` in ``tsr_engine.labels.model``. */
        AttributeView: {
            name: string;
            /** @enum {string} */
            kind: "checkbox" | "select" | "number" | "text";
            /** @description Whether the value may change from frame to frame. */
            mutable: boolean;
            /** @description Values of a select. */
            values: string[];
            low: number | null;
            high: number | null;
            default: boolean | number | string | null;
        };
        /** @description Overlap of boxes of two people. */
        BoxAgreement: {
            name: string;
            tracks: number;
            /** @description Number of frames in which two people have drawn a box of such a track. */
            frames: number;
            /** @description Mean over the tracks of the mean IoU over a track's frames; in [0, 1]. */
            iou: number;
            /** @description Lower end of the 95 % interval of that mean. */
            low: number;
            high: number;
        };
        /** @description Overlap in the whole library and its parts. */
        BoxAgreements: {
            whole: components["schemas"]["BoxAgreement"];
            labels: components["schemas"]["BoxAgreement"][];
            /** @description By the person who drew the first box. */
            first: components["schemas"]["BoxAgreement"][];
            /** @description By the person who drew the second box. */
            second: components["schemas"]["BoxAgreement"][];
        };
        /** @description Result of importing a file of labels. */
        Brought: {
            version: number;
            sentence: string;
            /** @description Whether the set was made from the file. */
            created: boolean;
            added: components["schemas"]["LabelView"][];
            known: components["schemas"]["KnownLabel"][];
            refused: components["schemas"]["RefusedLabel"][];
            /** @description Contents of the file that a set cannot hold. */
            reported: string[];
        };
        /** @description A folder. */
        Browse: {
            path: string;
            parent: string | null;
            folders: string[];
            videos: components["schemas"]["BrowseVideo"][];
            /** @description There are more: these are the first by name. */
            truncated: boolean;
        };
        /** @description A video file in a folder. */
        BrowseVideo: {
            name: string;
            path: string;
            size: number;
        };
        /** @description A bundle in the library. */
        BundleImport: {
            video: components["schemas"]["VideoView"];
            run: components["schemas"]["RunView"];
            report: components["schemas"]["BundleReportView"];
        };
        /** @description Frames to pack, and what the bundle is about. */
        BundleOrder: {
            first: number;
            stop: number;
            /** @default  */
            note?: string;
            /**
             * @description Keys of the tracks with the problem; empty: all corrected tracks.
             * @default []
             */
            tracks?: string[];
            /** @description Error of Eq. 7 that a corrected box may have; unset: 0.25. */
            max_eq7?: number | null;
        };
        /** @description Contents of an imported bundle. */
        BundleReportView: {
            note: string;
            video_name: string;
            first: number;
            stop: number;
            /** @description Frame of the original video that is the clip's frame 0. */
            offset: number;
            /** @description Frame of the clip to look at first: of the first expectation that failed, else the first frame that is judged. */
            frame: number;
            /** @description Track to look at in that frame. */
            track: string | null;
            expected: components["schemas"]["ExpectedView"][];
            corrections: number;
            /** @description Pictures that decode to other bits here than on the machine that made the bundle. */
            other_pictures: number;
            skipped: string[];
            engine_version: string;
        };
        /** @description Author and name of a run that is drawn by hand. */
        ByHand: {
            /** @default Drawn by hand */
            name?: string;
            author?: string | null;
        };
        /** @description Boxes of one reference label to which the candidate gives another label. */
        Cell: {
            /** @description None: nothing there; -1: a sign of none of the set's labels; below: see ``words`` of the matrix. */
            reference: number | null;
            /** @description None: missed; -1: found, with none of the set's labels. */
            candidate: number | null;
            count: number;
            frames: number[];
            lasts: number[];
            tracks: string[];
            partners: (string | null)[];
            pairs: components["schemas"]["Pair"][];
        };
        /** @description Result of a change. */
        Change: {
            version: number;
            label: components["schemas"]["LabelView"] | null;
            sentence: string;
        };
        /** @description One change of one person. */
        ChangeRequest: {
            author?: string | null;
            change: components["schemas"]["AddLabel"] | components["schemas"]["UpdateLabel"] | components["schemas"]["MergeLabels"] | components["schemas"]["HideLabel"] | components["schemas"]["ShowLabel"] | components["schemas"]["SetPicture"] | components["schemas"]["UndoChange"] | components["schemas"]["AdoptSet"];
        };
        /** @description The figures of a candidate against a reference, over the frames that both have. */
        Comparison: {
            video_id: string;
            /** @description Size of the video's picture, px. */
            width: number;
            height: number;
            reference: string;
            candidate: string;
            /** @description ``reference`` and ``candidate``. */
            sides: {
                [key: string]: components["schemas"]["SideView"];
            };
            first: number;
            last: number;
            figures: {
                [key: string]: components["schemas"]["Figure"];
            };
            confusion: components["schemas"]["Confusion"];
        };
        /** @description Matched boxes by label; missed ones have no candidate label, false ones no reference label. */
        Confusion: {
            /** @description Labels that occur, those below 0 last. */
            classes: number[];
            /** @description Words of models that the label set has no label for, by the number below -1 that replaces them here. */
            words: {
                [key: string]: string;
            };
            cells: components["schemas"]["Cell"][];
        };
        /** @description Add a track with its first box. */
        CreateTrack: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            class_id?: number | null;
            /** @description Key of the label ``class_id``, because the video may use another label set by now. */
            label_key?: string | null;
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "create_track";
            box: [
                number,
                number,
                number,
                number
            ];
        };
        /** @description State of the review screen; omitted fields stay as they are. */
        Cursor: {
            frame: number;
            /** @description key of the selected track; null: none */
            track?: string | null;
            /** @description one view of the run; unset: all of them */
            view?: string | null;
            mode?: ("volume" | "prior" | "drive") | null;
        };
        /** @description Delete the track from this frame on. */
        DeleteFrom: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "delete_from";
        };
        /** @description Delete the whole track. */
        DeleteTrack: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "delete_track";
        };
        /** @description One property before and after. */
        Difference: {
            /** @description ``label``, ``review``, ``boxes``, ``notes`` ...: see :func:`differences`. */
            what: string;
            before: unknown;
            /** @description For boxes, notes and attributes: only those that differ. */
            after: unknown;
            /**
             * @description How many further ones differ.
             * @default 0
             */
            more: number;
        };
        /** @description A track with different answers of two people that nobody has changed since. */
        Dispute: {
            run_id: string;
            video_id: string;
            video_name: string;
            key: string;
            frame: number;
            first: string;
            first_answer: string;
            second: string;
            second_answer: string;
        };
        /** @description One operation of a person. */
        Done: {
            seq: number;
            time: string;
            name: string;
            frame: number | null;
            /** @description Keys of its tracks; only the first few of many. */
            tracks: string[];
            /** @description Number of its tracks. */
            count: number;
            run_id: string;
            video_id: string;
            video_name: string;
        };
        /**
         * @description The corrections of an earlier run.
         *
         *     Attributes:
         *         run_id: the earlier run.
         *         tracks: number of corrected tracks in it.
         *         seq: number of its newest operation, which identifies its state for the page.
         */
        Earlier: {
            run_id: string;
            tracks: number;
            seq: number;
        };
        /** @description Corrections of an earlier run that can be carried over. */
        EarlierCorrections: {
            found: components["schemas"]["Earlier"] | null;
        };
        /** @description The answer to one operation; ``docs`` are the touched documents. */
        EditAnswer: {
            /** @description Number of the newest operation. */
            seq: number;
            docs: components["schemas"]["TrackDoc"][];
            /** @description The operation that Ctrl+Z undoes for this author. */
            undo: components["schemas"]["Target"] | null;
            redo: components["schemas"]["Target"] | null;
            op_id: string;
        };
        /** @description Another text. */
        EditNote: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "edit_note";
            note_id: string;
            text: string;
        };
        /** @description The shape of every answer of status 400 and above. */
        ErrorAnswer: {
            error: components["schemas"]["ErrorDetail"];
        };
        /** @description One failure. */
        ErrorDetail: {
            code: string;
            message: string;
            field: string | null;
            details: {
                [key: string]: unknown;
            } | null;
        };
        /** @description A box that a person may follow soon. */
        ExpectedFollow: {
            frame: number;
        };
        /** @description One expectation, and its result when the bundle was made. */
        ExpectedView: {
            id: string;
            expected: string;
            met: boolean;
            got: string;
        };
        /** @description The gate's data for one prediction. */
        Explanation: {
            symmetry: components["schemas"]["SymmetryView"];
            hash: components["schemas"]["HashView"];
            l_positive: number;
            tau: number;
        };
        /** @description Changes of the reviews in an export since it was made. */
        ExportAge: {
            id: string;
            /** @description Number of edits made since. */
            edits: number;
            /** @description Number of its edits that were undone since. */
            undone: number;
            /** @description Names of its videos whose run was removed. */
            gone: string[];
        };
        /** @description What to export, and how. */
        ExportRequest: {
            /** @description Runs of different videos. */
            runs: string[];
            format: string;
            /**
             * @default none
             * @enum {string}
             */
            pictures?: "none" | "annotated" | "all";
            /**
             * @description Review states to export. ``edited``: open tracks that a person has edited. ``rejected``: listed in the manifest
             *     as hard negatives.
             * @default [
             *       "edited",
             *       "accepted",
             *       "rejected"
             *     ]
             */
            states?: ("open" | "edited" | "accepted" | "rejected" | "needs_work")[];
            /** @description Keys or numbers of labels to export, -1: not in the set; null: all. */
            labels?: (string | number)[] | null;
            /** @description Labels by number, as in version 0.1. */
            classes?: number[] | null;
            /**
             * @description Treatment of signs without a label of the set: left out, regions to ignore, or a class of their own.
             * @default leave-out
             * @enum {string}
             */
            not_in_set?: "leave-out" | "ignore" | "class";
            /**
             * @description Labels that the files declare: all of the set, or only exported ones.
             * @default all
             * @enum {string}
             */
            class_map?: "all" | "used";
            /** @description Minimum shorter side of a box, px; smaller boxes are left out. */
            min_side?: number | null;
            /** @default 0 */
            first?: number;
            /** @description Frame after the last; null: to the end. */
            stop?: number | null;
            split?: components["schemas"]["Shares"] | null;
            /**
             * @default sign
             * @enum {string}
             */
            split_by?: "sign" | "video";
            /**
             * @description Give each side of the split every label with enough signs.
             * @default false
             */
            balance_labels?: boolean;
            /** @default 0 */
            split_seed?: number;
            /** @default 0.5 */
            thin_px?: number;
            /** @default {} */
            switches?: {
                [key: string]: string;
            };
            /** @description Keys of the tracks to export, by run; a run without an entry exports none. Null: all tracks. */
            tracks?: {
                [key: string]: string[];
            } | null;
            /**
             * @description File name without suffix; empty: made from the request.
             * @default
             */
            name?: string;
        };
        /**
         * @description One number and the places that it comes from.
         *
         *     A place is a range of frames of one track: ``frames[i]`` to ``lasts[i]`` of ``tracks[i]``. ``partners[i]`` is the
         *     other side's track in the first of them; None: there is none.
         */
        Figure: {
            /** @description None: there is nothing to measure. */
            value: number | null;
            /** @description Numerator and denominator, for shares. */
            of: [
                number,
                number
            ] | null;
            frames: number[];
            lasts: number[];
            tracks: string[];
            partners: (string | null)[];
            /** @description Number of places, even if the lists are cut. */
            places: number;
            /**
             * @description Both boxes in the first frame of each place.
             * @default []
             */
            pairs: components["schemas"]["Pair"][];
            /** @description Error of each place; set if the places are ordered by it. */
            errors: number[] | null;
        };
        /** @description One track with verdicts that change. */
        FlippedTrack: {
            id: number;
            flips: number;
            /** @description First frame with a changed verdict. */
            frame: number;
        };
        /** @description Answer for one tau. Verdicts are those on the run's own boxes; a replay may give other boxes. */
        Flips: {
            tau: number;
            run_tau: number;
            /** @description Number of all verdicts. */
            verdicts: number;
            to_confident: number;
            to_rejected: number;
            /** @description In order of id. */
            tracks: components["schemas"]["FlippedTrack"][];
        };
        /** @description Public data on this machine, inside the allowed folders. */
        Folders: {
            gtsdb?: string | null;
            gtsrb?: string | null;
        };
        /** @description Set followed boxes; frames between them are interpolated, and at least one of the boxes is an anchor. */
        Follow: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "follow";
            boxes: components["schemas"]["FollowedBox"][];
        };
        /** @description A box that a person has set. */
        FollowAnchor: {
            frame: number;
            box: [
                number,
                number,
                number,
                number
            ];
        };
        /** @description Why following stopped in one direction; proposals beyond ``frame`` are withdrawn. */
        FollowEnding: {
            /** @enum {string} */
            direction: "backward" | "forward";
            frame: number;
            reason: string;
            sentence: string;
        };
        /** @description A sign that the server follows. Its proposals are no data until a person accepts them. */
        FollowView: {
            id: string;
            run_id: string;
            /** @description The track. */
            key: string;
            anchors: components["schemas"]["FollowAnchor"][];
            only: ("forward" | "backward" | "between") | null;
            first: number;
            last: number | null;
            /** @enum {string} */
            state: "queued" | "running" | "complete" | "failed" | "cancelled";
            error: string | null;
            /** @description What a worker does for it besides its progress, in a few words; empty: nothing to say. */
            note: string;
            /** @description frame, x1, y1, x2, y2, confidence, source; a later proposal for a frame replaces the earlier one. */
            proposals: [
                number,
                number,
                number,
                number,
                number,
                number,
                "anchor" | "detected" | "matched" | "predicted"
            ][];
            endings: components["schemas"]["FollowEnding"][];
            /** @description Request the proposals after this number next time. */
            next: number;
        };
        /** @description One box of a followed track. */
        FollowedBox: {
            frame: number;
            box: [
                number,
                number,
                number,
                number
            ];
            /**
             * @description A person has set this box; the other boxes are followed from such boxes.
             * @default false
             */
            anchor?: boolean;
        };
        /** @description One format of annotation files. */
        FormatView: {
            name: string;
            title: string;
            /** @description One sentence. */
            summary: string;
            can_export: boolean;
            can_import: boolean;
            needs_pictures: boolean;
            allows_pictures: boolean;
            /** @description It can mark regions to ignore. */
            ignores: boolean;
            /** @description It marks key frames, so that the limit of thinning matters. */
            key_frames: boolean;
            export_switches: components["schemas"]["SwitchView"][];
            import_switches: components["schemas"]["SwitchView"][];
            docs: string;
        };
        /** @description All formats. */
        Formats: {
            formats: components["schemas"]["FormatView"][];
        };
        /** @description The open follow of an author in a run, if any. */
        FoundFollow: {
            found: components["schemas"]["FollowView"] | null;
        };
        /** @description The label of a track. */
        FoundLabel: {
            set: string;
            id: number;
            name: string;
        };
        /** @description One track, with the frame and the box to show. */
        FoundTrack: {
            run: string;
            run_name: string;
            video: string;
            video_name: string;
            tags: string[];
            key: string;
            /** @description None: none of the set's labels, or not classified. */
            label: components["schemas"]["FoundLabel"] | null;
            state: string;
            uncertainty: number;
            size: number;
            frame: number;
            box: [
                number,
                number,
                number,
                number
            ];
            first: number;
            last: number;
            revision: number;
            author: string | null;
            edited: string | null;
            notes: boolean;
        };
        /** @description Number of tracks that were assigned. */
        Given: {
            given: number;
            /** @description Number of tracks of the library that others have accepted. */
            accepted: number;
            /** @description Number of runs whose tracks or newest edits are not included yet. */
            unread: number;
        };
        /** @description One sign in one frame. */
        GroundTruthBox: {
            frame: number;
            track: number;
            box: [
                number,
                number,
                number,
                number
            ];
            /** @description None: a sign of no known class. */
            class_id: number | null;
            visibility: number;
            ignore: boolean;
        };
        /** @description A window of frames. */
        GroundTruthBoxes: {
            boxes: components["schemas"]["GroundTruthBox"][];
        };
        /** @description One ground truth of a video. */
        GroundTruthView: {
            id: string;
            name: string;
            count: number;
        };
        /** @description All ground truths of a video. */
        GroundTruths: {
            ground_truths: components["schemas"]["GroundTruthView"][];
        };
        /** @description One operation on the track. */
        Happened: {
            seq: number;
            author: string;
            /** @description ISO 8601, UTC, by the clock of the server that stored it; the order is that of ``seq``. */
            time: string;
            /** @description Kind of the command, or ``undo`` and ``redo``. */
            name: string;
            frame: number | null;
            differences: components["schemas"]["Difference"][];
        };
        /** @description 64 bits each, as 16 hexadecimal digits, first bit highest, row by row. */
        HashView: {
            crop: string;
            mean: string;
            distance: number;
        };
        /** @description Stop offering the label. */
        HideLabel: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "hide";
            id: number;
        };
        /** @description Mark the tracks as regions to ignore, or remove that mark. */
        Ignore: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "ignore";
            value: boolean;
        };
        /** @description Progress of an import. */
        ImportProgress: {
            /** @enum {string} */
            step: "waiting" | "reading" | "storing";
            /** @description Number of boxes read so far. */
            boxes: number;
            /** @description Seconds since its file was received. */
            seconds: number;
        };
        /**
         * @description The result of an import.
         *
         *     Attributes:
         *         kind: import as this kind.
         *         id: the ground truth or run; for an annotation the corrected run.
         *         tracks: number of imported tracks; for an annotation, of new and changed ones.
         *         boxes: number of their boxes.
         *         same: number of tracks of an annotation that the run already showed.
         *         edit: number of the operation in the run's log: the annotation, or an imported run's marks (hidden, verdicts,
         *             notes); one undo reverts it. None: there is nothing to undo.
         *         repaired: repairs, one sentence each.
         *         skipped: what was left out.
         */
        ImportResult: {
            /** @enum {string} */
            kind: "annotation" | "truth" | "run";
            id: string;
            tracks: number;
            boxes: number;
            /** @default 0 */
            same: number;
            edit: number | null;
            repaired: string[];
            skipped: components["schemas"]["SkippedView"][];
        };
        /** @description Interpolate linearly between the key frames of a range; ``value`` false: show the engine's boxes again. */
        Interpolate: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "interpolate";
            first: number;
            last: number;
            /** @default true */
            value?: boolean;
        };
        /** @description Set a verdict. */
        Judge: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "judge";
            /** @enum {string} */
            review: "open" | "accepted" | "rejected" | "needs_work";
        };
        /** @description A person's values for one frame and the frames up to the next key frame. */
        KeyFrame: {
            /** @description Null: the box is the engine's. */
            box: [
                number,
                number,
                number,
                number
            ] | null;
            /**
             * @description From here to the next key frame.
             * @default false
             */
            occluded: boolean;
            /**
             * @description No box from here to the next key frame.
             * @default false
             */
            outside: boolean;
            /**
             * @description Straight line from here to the next key frame with a box.
             * @default false
             */
            interpolate: boolean;
            /** @description Label of this box only; null: the track's; -1: none of the classes. */
            class_id: number | null;
            /**
             * @description The box was followed from a person's boxes in other frames; a new follow may replace it.
             * @default false
             */
            followed: boolean;
            /** @description Attributes that differ from the track's in these frames. */
            attributes?: {
                [key: string]: boolean | number | string;
            };
        };
        /** @description A label of a file that the set has. */
        KnownLabel: {
            /** @description Name in the file. */
            name: string;
            id: number;
            key: string;
        };
        /** @description A label that can be chosen. */
        LabelChoice: {
            id: number;
            name: string;
        };
        /** @description One set. */
        LabelSetView: {
            key: string;
            name: string;
            version: number;
            /** @description Number of labels, hidden and merged ones included. */
            labels: number;
            /** @description Whether videos that name no set use it. */
            default: boolean;
            /** @description Whether it ships with tsr; the library may have changed it since. */
            shipped: boolean;
        };
        /** @description Use of the labels of a set. */
        LabelUsage: {
            /** @description By id of the label. Labels without tracks are left out. */
            labels: {
                [key: string]: components["schemas"]["LabelUse"];
            };
            /** @description Number of videos whose tracks or newest edits are not counted, because the search has not read them. */
            unread: number;
        };
        /** @description Use of a label. */
        LabelUse: {
            /** @description Number of tracks with the label, in the current run of each video, without regions to ignore. */
            tracks: number;
            /** @description Their videos. */
            videos: number;
        };
        /** @description One version of a set. */
        LabelVersion: {
            version: number;
            author: string;
            /** @description None: the version that ships with tsr. */
            created: string | null;
            sentence: string;
            undoes: number | null;
        };
        /** @description One label of a set. */
        LabelView: {
            id: number;
            key: string;
            name: string;
            /** @description Short name; empty: the first 12 characters of the name are used. */
            short: string;
            aliases: string[];
            /** @description Address of the pictogram; null: it has none. */
            picture: string | null;
            /** @enum {string} */
            shape: "triangle" | "inverted triangle" | "circle" | "octagon" | "diamond" | "rectangle" | "other";
            /** @enum {string} */
            category: "prohibitory" | "mandatory" | "danger" | "priority" | "information" | "direction" | "additional" | "other";
            attributes: components["schemas"]["AttributeView"][];
            size_mm: number | null;
            /** @description Key of the label of its mirror image. */
            mirror: string | null;
            /**
             * @description Use in retraining: sign, background or ignore.
             * @enum {string}
             */
            teach: "sign" | "background" | "ignore";
            /** @description `#rrggbb`. */
            colour: string | null;
            /** @description Digit key, 1 to 9. */
            pinned: number | null;
            /** @description Whether it is no longer offered. */
            hidden: boolean;
            /** @description Id of the label that replaces it. */
            merged_into: number | null;
        };
        /** @description The sources of each track over time: one entry per run of equal source, by track, then by frame. */
        LaneColumns: {
            track: number[];
            first: number[];
            /** @description Inclusive. */
            last: number[];
            /** @description 0 detected, 1 predicted, 2 relocalised. */
            source: number[];
        };
        /** @description A path that opens the page once. */
        Link: {
            path: string;
        };
        /** @description Rows of the log. */
        Log: {
            edits: components["schemas"]["LogEntry"][];
        };
        /** @description One row of the log. */
        LogEntry: {
            seq: number;
            op_id: string;
            author: string;
            name: string;
            frame: number | null;
            reverts: string | null;
            command: {
                [key: string]: unknown;
            };
            keys: string[];
            time: string;
        };
        /** @description A sign to look at, without the first person's answer. */
        Look: {
            id: number;
            run_id: string;
            video_name: string;
            frame: number;
            box: [
                number,
                number,
                number,
                number
            ];
            labels: components["schemas"]["LabelChoice"][];
        };
        /**
         * @description Videos with such tracks.
         *
         *     Attributes:
         *         videos: video id -> number of such tracks.
         *         left: number of videos that are not counted yet; ask again.
         *         unreadable: number of videos whose tracks cannot be read here.
         */
        Matches: {
            videos: {
                [key: string]: number;
            };
            left: number;
            unreadable: number;
        };
        /** @description A label that a word of the request means. */
        MeantLabel: {
            set: string;
            id: number;
            name: string;
        };
        /**
         * @description Merge other tracks into the track; in frames of both, the track's own box is kept.
         *
         *     ``class_id`` is the engine's class of the track according to the page, for a track that would get the label of
         *     another one. ``gaps`` are the frames after their start in which the engine's tracks have no box. The server reads
         *     both from the evidence instead.
         */
        Merge: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "merge";
            others: string[];
            class_id?: number | null;
            gaps?: components["schemas"]["Segment"][];
        };
        /** @description Replace the label ``id`` by ``into`` from now on. */
        MergeLabels: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "merge";
            id: number;
            into: number;
        };
        /** @description One version of the model files. */
        ModelView: {
            /** @description Id; `shipped`: the engine's models. */
            id: string;
            name: string;
            state: string;
            error: string | null;
            parent_id: string | null;
            lineage: {
                [key: string]: unknown;
            };
            figures: {
                [key: string]: unknown;
            };
            /** @description Part -> SHA-256. */
            models: {
                [key: string]: string;
            };
            stage: string;
            /** @description What a worker does for it besides its progress, in a few words; empty: nothing to say. */
            note: string;
            done: number;
            total: number | null;
            active: boolean;
            created: string;
            finished: string | null;
            /** @description Number of labels that it can classify. */
            labels: number;
            /** @description Names of labels of the library's set that it cannot classify. */
            lacks: string[];
        };
        /** @description Versions, the newest first; the shipped one is the last. */
        Models: {
            models: components["schemas"]["ModelView"][];
            active: string | null;
        };
        /** @description Number of open views that were updated. */
        Moved: {
            views: number;
        };
        /** @description Videos or frames to assign, and the person. */
        NewAssignments: {
            videos: string[];
            person: string;
            /** @default 0 */
            first?: number;
            stop?: number | null;
            /** @default  */
            comment?: string;
        };
        /** @description See ``Attribute`` in ``tsr_engine.labels.model``. */
        NewAttribute: {
            name: string;
            /** @enum {string} */
            kind: "checkbox" | "select" | "number" | "text";
            /** @default false */
            mutable?: boolean;
            values?: string[];
            low?: number | null;
            high?: number | null;
            default?: boolean | number | string | null;
        };
        /** @description Boxes to follow from. */
        NewFollow: {
            key: string;
            anchors: components["schemas"]["FollowAnchor"][];
            only?: ("forward" | "backward" | "between") | null;
            /** @default 0 */
            first?: number;
            last?: number | null;
            author?: string | null;
        };
        /** @description Sources of a new version. */
        NewModel: {
            /** @default  */
            name?: string;
            /**
             * @default [
             *       "detector",
             *       "prior",
             *       "lambda",
             *       "classifier",
             *       "online"
             *     ]
             */
            parts?: ("detector" | "prior" | "lambda" | "classifier" | "online")[];
            /**
             * @description Runs of different videos; their corrections are read when training starts.
             * @default []
             */
            reviews?: string[];
            /**
             * @description Ids of exports.
             * @default []
             */
            exports?: string[];
            folders?: components["schemas"]["Folders"];
            /** @default 0 */
            seed?: number;
            /** @description Version to start from; null: the active one. */
            parent?: string | null;
        };
        /** @description The new name of a run. */
        NewName: {
            name: string;
        };
        /** @description Configuration of a run. */
        NewRun: {
            /** @default default */
            preset?: string;
            /** @default {} */
            parameters?: {
                [key: string]: boolean | number | string | number[] | null;
            };
            /** @default 0 */
            first?: number;
            stop?: number | null;
            /** @default  */
            name?: string;
        };
        /** @description A scene to export as a file. */
        NewScene: {
            /**
             * @default volume
             * @enum {string}
             */
            mode?: "volume" | "prior" | "drive";
            /** @description the cursor; unset: the run's first frame */
            frame?: number | null;
            track?: string | null;
            /**
             * @default class
             * @enum {string}
             */
            colour?: "class" | "verdict" | "source";
            /** @description seconds around the cursor; 0: the whole run */
            stretch?: number | null;
            /**
             * @description assumed horizontal field of view, degrees
             * @default 60
             */
            view?: number;
            /**
             * @description assumed size of signs, against the catalogue's
             * @default 1
             */
            size?: number;
            /** @default  */
            name?: string;
        };
        /** @description A person, and the share of the accepted tracks to look at. */
        NewSecondOpinions: {
            person: string;
            share: number;
        };
        /** @description A file on the server's machine. */
        NewVideo: {
            path: string;
        };
        /** @description Parameters to change, compared with the run that is replayed. */
        NewWhatIf: {
            parameters: {
                [key: string]: boolean | number | string | number[] | null;
            };
            /** @default  */
            name?: string;
        };
        /** @description The next sign for a person to look at. */
        NextLook: {
            look: components["schemas"]["Look"] | null;
            left: number;
        };
        /** @description A remark pinned to a frame. */
        Note: {
            id: string;
            frame: number;
            text: string;
            author: string;
            time: string;
        };
        /** @description An action's operation in the log of one run. */
        "Operation-Output": {
            run: string;
            op_id: string;
        };
        /** @description One file that was made from runs, or is being made. */
        OutputView: {
            id: string;
            kind: string;
            run_id: string | null;
            /** @description Name of the file. */
            name: string;
            state: string;
            error: string | null;
            options: {
                [key: string]: unknown;
            };
            done: number;
            total: number | null;
            /** @description Bytes. */
            size: number | null;
            sha256: string;
            /** @description For an export: title, counts, skipped, skipped_count, videos, split. */
            summary: {
                [key: string]: unknown;
            };
            created: string;
            finished: string | null;
        };
        /** @description Outputs, the newest first. */
        Outputs: {
            outputs: components["schemas"]["OutputView"][];
        };
        /** @description Contents of the layers of one frame. */
        Overlay: {
            frame: number;
            detections: components["schemas"]["OverlayDetection"][];
            tracks: components["schemas"]["OverlayTrack"][];
        };
        /** @description One offline detection. */
        OverlayDetection: {
            box: [
                number,
                number,
                number,
                number
            ];
            raw: number;
            prior: number;
            score: number;
            track: number | null;
        };
        /** @description The gate's verdict on the prediction. */
        OverlayGate: {
            l_positive: number;
            confident: boolean;
        };
        /** @description The box that the motion model expected, and its uncertainty. */
        OverlayPrediction: {
            box: [
                number,
                number,
                number,
                number
            ];
            sigma: [
                number,
                number,
                number,
                number
            ];
        };
        /** @description The online detector's result in place of a rejected prediction. */
        OverlayRelocalisation: {
            search: [
                number,
                number,
                number,
                number
            ];
            box: [
                number,
                number,
                number,
                number
            ];
            decision: number;
            probability: number;
            runner_up: [
                number,
                number,
                number,
                number
            ];
            runner_up_decision: number;
        };
        /** @description One track in one frame. */
        OverlayTrack: {
            id: number;
            /** @enum {string} */
            state: "tentative" | "confirmed";
            /** @enum {integer} */
            source: 0 | 1 | 2;
            box: [
                number,
                number,
                number,
                number
            ];
            /** @description Label of the video's set; None: not classified; -1: the set lacks the engine's class. */
            class_id: number | null;
            /** @description The engine's name of it, if the set lacks it. */
            word: string | null;
            share: number | null;
            /** @description Standard deviation of cx, cy, w, h, px. */
            prediction: components["schemas"]["OverlayPrediction"] | null;
            gate: components["schemas"]["OverlayGate"] | null;
            relocalisation: components["schemas"]["OverlayRelocalisation"] | null;
        };
        /** @description A window of frames. */
        Overlays: {
            overlays: components["schemas"]["Overlay"][];
        };
        /** @description The current runs of the videos in the search's tables, and the work of the last 30 days. */
        Overview: {
            videos: number;
            /** @description Number of tracks, without deleted ones and regions to ignore. */
            tracks: number;
            reviewed: number;
            rejected: number;
            notes: number;
            /** @description Number of runs whose tracks or newest edits are missing in these figures: not read yet, or unreadable. */
            unread: number;
            /** @description Number of tracks with verdicts of two people. */
            decided_twice: number;
            /** @description Number of them with equal verdicts. */
            agreed: number;
            people: components["schemas"]["Worker"][];
            /** @description A sentence if times in the log are wrong. */
            clocks: string | null;
        };
        /** @description The box of a place, and the other side's box there: its partner, or else the box that overlaps it most. */
        Pair: {
            box: [
                number,
                number,
                number,
                number
            ];
            /** @description -1: a sign of none of the set's labels; below: see ``words`` of the matrix. */
            label: number;
            /** @description Track of the other side; None: none of its boxes overlaps. */
            other: string | null;
            other_box: [
                number,
                number,
                number,
                number
            ] | null;
            other_label: number | null;
            /** @description Intersection over union of the two, in [0, 1]; 0 if there is no other box. */
            iou: number;
        };
        /** @description One parameter of the engine. */
        Parameter: {
            section: string;
            name: string;
            /** @enum {string} */
            type: "number" | "integer" | "boolean" | "choice" | "text";
            default: boolean | number | string | number[] | null;
            low: number | null;
            high: number | null;
            choices: string[] | null;
            description: string;
            /** @description A what-if may change it. */
            replayable: boolean;
            /** @description Preset -> value where it departs. */
            presets: {
                [key: string]: boolean | number | string | number[] | null;
            };
        };
        /** @description Everybody. */
        People: {
            people: components["schemas"]["PersonView"][];
        };
        /** @description An account. */
        PersonView: {
            name: string;
            /** @enum {string} */
            role: "viewer" | "annotator" | "reviewer" | "admin";
            created: string;
            /** @description Number of assignments that are not done. */
            assignments: number;
        };
        /** @description Frames and contents of a recording. */
        RecordingOrder: {
            first: number;
            stop: number;
            /** @default  */
            name?: string;
            /** @description The frame to show first. */
            frame?: number | null;
            /** @description The track to select. */
            track?: string | null;
            /** @description Ground truth to include; unset: the video's, if it has exactly one. */
            truth?: string | null;
        };
        /** @description Redo an operation that was undone. */
        Redo: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "redo";
            op_id: string;
        };
        /** @description A name of a file that is not allowed as a label. */
        RefusedLabel: {
            name: string;
            reason: string;
        };
        /** @description Set a label by key, name or alias; each video has its own set. */
        Relabel: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "relabel";
            label: string;
        };
        /** @description Set the label of the box in this frame only; null: the track's label again. ``box`` is the displayed box. */
        RelabelBox: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            class_id: number | null;
            /** @description Key of the label ``class_id``, because the video may use another label set by now. */
            label_key?: string | null;
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "relabel_box";
            box?: [
                number,
                number,
                number,
                number
            ] | null;
        };
        /** @description Set the label of the whole track; null: the engine's label again, -1: none of the classes. */
        RelabelTrack: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            class_id: number | null;
            /** @description Key of the label ``class_id``, because the video may use another label set by now. */
            label_key?: string | null;
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "relabel_track";
        };
        /** @description Remove the key frame at this frame. */
        RemoveKey: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "remove_key";
        };
        /** @description Remove a note. */
        RemoveNote: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "remove_note";
            note_id: string;
        };
        /** @description Ids of the runs that were removed. */
        RemovedRuns: {
            removed: string[];
        };
        /** @description Restore a deleted track. */
        RestoreTrack: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "restore_track";
        };
        /**
         * @description Progress of the review of the newest complete run, counted as in the queue.
         *
         *     ``tracks`` counts existing tracks: without deleted and merged ones, with those that people made. ``reviewed`` counts
         *     the accepted and rejected ones of them.
         */
        ReviewProgress: {
            tracks: number;
            reviewed: number;
        };
        /** @description The current review of a video: that of its newest run with corrections. */
        ReviewSource: {
            run: string;
            run_name: string;
            video: string;
            video_name: string;
            /** @description Number of the newest edit; 0: there is none, its documents were imported. */
            edit_revision: number;
            accepted: number;
            /** @description False positives, which training uses as background. */
            rejected: number;
            /** @description Undecided tracks. */
            left: number;
        };
        /** @description Set the same verdict on the track and on others, in one operation that one undo reverts. */
        ReviewTracks: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "review_tracks";
            others: string[];
            /** @enum {string} */
            review: "open" | "accepted" | "rejected" | "needs_work";
        };
        /** @description One run over a video. */
        RunView: {
            id: string;
            video_id: string;
            kind: string;
            name: string;
            parent_id: string | null;
            state: string;
            error: string | null;
            preset: string;
            /** @description Parameters that differ from the preset. */
            parameters: {
                [key: string]: unknown;
            };
            first: number;
            stop: number | null;
            frames_done: number;
            frames_total: number | null;
            /** @description Frames per second. */
            rate: number | null;
            /** @description S. */
            remaining: number | null;
            /** @description What a worker does for it besides its progress, in a few words; empty: nothing to say. */
            note: string;
            /** @description Confirmed tracks. */
            tracks: number | null;
            engine_version: string;
            models: {
                [key: string]: string;
            };
            /**
             * @description Of a complete run; `focus`: its camera's focus of expansion, null or {x, y: shares of the picture, named: by
             *     a person}; of a what-if: `identical_frames`, `missing_pixels` in `missing_frames` that the evidence lacks,
             *     `difference`.
             */
            summary: {
                [key: string]: unknown;
            };
            created: string;
            finished: string | null;
        };
        /** @description Some runs. */
        Runs: {
            runs: components["schemas"]["RunView"][];
        };
        /** @description The bundled drive that the first screen offers. */
        Sample: {
            video_id: string;
            run_id: string | null;
        };
        /** @description Address of a view of the run. */
        Scene3d: {
            url: string;
            view: string;
            modes: components["schemas"]["Scene3dMode"][];
        };
        /** @description One of the scenes. */
        Scene3dMode: {
            /** @enum {string} */
            id: "volume" | "prior" | "drive";
            title: string;
        };
        /** @description One page of results. */
        SearchAnswer: {
            tracks: components["schemas"]["FoundTrack"][];
            /** @description Cursor of the next page; None: there is none. */
            next: string | null;
            /** @description Number of found tracks; at most 10,000 are counted. */
            total: number;
            /** @description Whether there are more than that. */
            more: boolean;
            /** @description Labels that the words of ``label`` mean. */
            labels: components["schemas"]["MeantLabel"][];
            /** @description Number of runs whose tracks or newest edits are missing in the answer. */
            unread: number;
            /** @description The first unreadable runs, with the reason. */
            unreadable: components["schemas"]["Unreadable"][];
            unreadable_count: number;
        };
        /** @description The second person's label of a sign. */
        SecondAnswer: {
            /** @description -1: none of the set; None: it is no sign. */
            label: number | null;
        };
        /** @description Results of second opinions. */
        SecondOpinions: {
            /** @description Number of looks that are assigned and not answered. */
            open: number;
            whole: components["schemas"]["Agreement"];
            labels: components["schemas"]["Agreement"][];
            /** @description By the person who accepted the track. */
            first: components["schemas"]["Agreement"][];
            /** @description By the person who gave the second answer. */
            second: components["schemas"]["Agreement"][];
            /** @description Overlap of boxes of tracks that two people have drawn, with or without a second opinion. */
            boxes: components["schemas"]["BoxAgreements"];
            /** @description The first disputes. */
            disputes: components["schemas"]["Dispute"][];
            disputed: number;
        };
        /** @description A part of an engine track. */
        Segment: {
            track: number;
            first: number;
            /** @description Inclusive. */
            last: number;
        };
        /** @description State that the page starts from. */
        SessionAnswer: {
            version: string;
            /** @description Version of the page's files, as in their addresses. */
            page: string;
            /** @description Name that edits carry unless the page sets another. */
            author: string;
            /** @description None: the library has no people, but one user. */
            person: components["schemas"]["SignedIn"] | null;
            /** @description Folders from which videos may be added. */
            roots: string[];
            /** @description Largest upload. */
            upload_bytes: number;
            /** @description The bundled drive. */
            sample: components["schemas"]["Sample"] | null;
            presets: string[];
        };
        /**
         * @description Set an attribute of the whole track, or from this frame on until its next change.
         *
         *     ``value`` null removes it: from the whole track, or from this frame on, where the track's value then applies.
         *     ``box`` is the displayed box.
         */
        SetAttribute: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "attribute";
            attribute: string;
            value: boolean | number | string | null;
            /** @default false */
            from_here?: boolean;
            box?: [
                number,
                number,
                number,
                number
            ] | null;
        };
        /** @description Draw, move or resize a box: the frame becomes a key frame with this box. */
        SetBox: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "set_box";
            box: [
                number,
                number,
                number,
                number
            ];
        };
        /** @description Mark the track as a region to ignore: it may be a sign, is not counted, and training does not use it. */
        SetIgnore: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "ignore";
            value: boolean;
        };
        /** @description Mark that the track is no traffic sign. */
        SetNotASign: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "set_not_a_sign";
            value: boolean;
        };
        /** @description Mark as occluded (or not) from here to the next key frame; ``box`` is the displayed box. */
        SetOccluded: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "set_occluded";
            value: boolean;
            box?: [
                number,
                number,
                number,
                number
            ] | null;
        };
        /** @description Mark as out of view (or back) from here to the next key frame; ``box`` is the displayed box. */
        SetOutside: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "set_outside";
            value: boolean;
            box?: [
                number,
                number,
                number,
                number
            ] | null;
        };
        /** @description Set the picture of the label: PNG, at most 512 px and 256 KB; null removes it. */
        SetPicture: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "picture";
            id: number;
            png: string | null;
        };
        /** @description Set the verdict on the track. */
        SetReview: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "set_review";
            /** @enum {string} */
            review: "open" | "accepted" | "rejected" | "needs_work";
        };
        /** @description Shares of the boxes; they need not add up to 1. */
        Shares: {
            /** @default 0.8 */
            train?: number;
            /** @default 0.2 */
            val?: number;
            /** @default 0 */
            test?: number;
        };
        /** @description Offer a hidden label again. */
        ShowLabel: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "show";
            id: number;
        };
        /** @description One side, for the heading. */
        SideView: {
            name: string;
            kind: string;
            tracks: number;
            boxes: number;
            /** @description Names of tracks that people have made, by key; the engine's are named by their number. */
            names: {
                [key: string]: string;
            };
            /** @description Whether the side is a run without its corrections, although people have corrected it. */
            edited: boolean;
        };
        /** @description Credentials of a person. */
        SignIn: {
            token: string;
        };
        /** @description The person who is signed in. */
        SignedIn: {
            name: string;
            /** @enum {string} */
            role: "viewer" | "annotator" | "reviewer" | "admin";
            /** @description False: a proxy or a token identifies the person. */
            can_sign_out: boolean;
        };
        /** @description Something that was not imported. */
        SkippedView: {
            what: string;
            reason: string;
        };
        /**
         * @description Split the track: from this frame on it is another track.
         *
         *     ``class_id`` is the engine's class of the track according to the page, for a half that would get no label or that of
         *     another track; the server reads it from the evidence instead.
         */
        Split: {
            /** @description The current frame of the page. */
            frame: number;
            key: string;
            /** @description The page's spans of engine tracks without a document; the server reads them from the evidence instead. */
            spans?: components["schemas"]["Segment"][];
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "split";
            new_key: string;
            class_id?: number | null;
        };
        /** @description A new run in the queue. */
        StartedRun: {
            id: string;
            video_id: string;
            kind: string;
            name: string;
            parent_id: string | null;
            state: string;
            error: string | null;
            preset: string;
            /** @description Parameters that differ from the preset. */
            parameters: {
                [key: string]: unknown;
            };
            first: number;
            stop: number | null;
            frames_done: number;
            frames_total: number | null;
            /** @description Frames per second. */
            rate: number | null;
            /** @description S. */
            remaining: number | null;
            /** @description What a worker does for it besides its progress, in a few words; empty: nothing to say. */
            note: string;
            /** @description Confirmed tracks. */
            tracks: number | null;
            engine_version: string;
            models: {
                [key: string]: string;
            };
            /**
             * @description Of a complete run; `focus`: its camera's focus of expansion, null or {x, y: shares of the picture, named: by
             *     a person}; of a what-if: `identical_frames`, `missing_pixels` in `missing_frames` that the evidence lacks,
             *     `difference`.
             */
            summary: {
                [key: string]: unknown;
            };
            created: string;
            finished: string | null;
            /** @description One sentence for each parameter with an old name. */
            warnings: string[];
        };
        /** @description An option of one format. */
        SwitchView: {
            name: string;
            /** @description Possible values, the default first. */
            values: string[];
            help: string;
            /** @description Other texts are allowed too. */
            free: boolean;
        };
        /** @description The mirror axis and the pairs of features behind it, in px of the crop of the prediction. */
        SymmetryView: {
            /** @description Ends of the axis within the sign; None: no axis was found. */
            axis: [
                number,
                number,
                number,
                number
            ] | null;
            /** @description ``x1, y1, x2, y2, weight``; a feature on the axis matches itself. */
            matches: [
                number,
                number,
                number,
                number,
                number
            ][];
            magnitude: number;
            /** @description Width and height of the crop. */
            size: [
                number,
                number
            ];
        };
        /** @description The presentation time of each frame of a video, and the frames at which decoding can start. */
        TableAnswer: {
            frames: number;
            /** @description Numerator, denominator: pts * n / d = seconds. */
            time_base: [
                number,
                number
            ];
            first_pts: number;
            /** @description Runs of equal pts steps: [step, count]. */
            steps: [
                number,
                number
            ][];
            /** @description Ordinals of key frames. */
            keys: number[];
            /** @description Ordinals of damaged frames. */
            corrupt: number[];
        };
        /** @description Tags to add to videos and to remove from them. */
        TagRequest: {
            videos: string[];
            /** @default [] */
            add?: string[];
            /** @default [] */
            remove?: string[];
        };
        /** @description Result of a change of tags. */
        Tagged: {
            /** @description Videos whose tags changed. */
            changed: number;
        };
        /** @description Signs of a ground truth to copy to a run: by number, or all of a label. */
        TakeOver: {
            truth: string;
            /** @default [] */
            signs?: number[];
            /** @description Id, key or name; -1: signs of none of the labels. */
            label?: number | string | null;
            author?: string | null;
        };
        /**
         * @description Result of copying the signs.
         *
         *     Attributes:
         *         changed: number of tracks of the run that changed.
         *         made: number of new tracks.
         *         same: number of signs that the run already showed.
         *         op_id: id of the operation, for an undo; None: nothing has changed.
         *         repaired: repairs, one sentence each.
         *         skipped: what was left out and why, one sentence each.
         */
        TakenOver: {
            changed: number;
            made: number;
            same: number;
            op_id: string | null;
            repaired: string[];
            skipped: string[];
        };
        /** @description The operation that Ctrl+Z or Ctrl+Shift+Z applies to. */
        Target: {
            op_id: string;
            name: string;
            frame: number | null;
            keys: string[];
        };
        /** @description The confirmed tracks of a run: one column per property, one entry per track. */
        TrackColumns: {
            id: number[];
            first: number[];
            last: number[];
            frames: number[];
            /** @description Number of frames with a detection. */
            detected: number[];
            /** @description Frame in which the sign is seen best: the largest sharp view that is not cut off by the picture. */
            clearest: number[];
            /** @description Box in the first frame, px; a large one means that the sign was visible before. */
            first_box: ([
                number,
                number,
                number,
                number
            ] | null)[];
            /** @description Box in the last frame, px. */
            last_box: ([
                number,
                number,
                number,
                number
            ] | null)[];
            /** @description Label of the video's set; None: not classified; -1: the set lacks the engine's class. */
            class_id: (number | null)[];
            /** @description The engine's name of it, if the set lacks it. */
            word: (string | null)[];
            /** @description Share of the fused class in all votes. */
            share: (number | null)[];
            runner_up: (number | null)[];
            runner_up_word: (string | null)[];
            runner_up_share: (number | null)[];
            /** @description Best final score. */
            score: number[];
            /** @description Longest side, px. */
            side: number[];
            /** @description Number of frames with a rejected prediction. */
            rejected: number[];
            relocalised: number[];
            /** @description Probability that a person changes the track; None: unknown, because the run was imported. */
            uncertainty: (number | null)[];
            /** @description The same under its former name. */
            doubt: (number | null)[];
            /** @description Sort key of the queue: the uncertainty, with people's corrections at the time of the request. */
            rank: number[];
            /** @description Reasons for the uncertainty, as sentences. */
            reasons: string[][];
            tau: number;
            /** @description False while the run goes on. */
            complete: boolean;
        };
        /** @description A person's corrections of one track. An untouched track has no document. */
        TrackDoc: {
            /** @description `m7`: the engine's track 7; `h...`: made by a person. */
            key: string;
            /**
             * @description 0: untouched.
             * @default 0
             */
            revision: number;
            /** @description Null: the engine's class applies; -1: a person says that it is none of the classes. */
            class_id: number | null;
            /**
             * @default open
             * @enum {string}
             */
            review: "open" | "accepted" | "rejected" | "needs_work";
            /**
             * @description How older versions marked a false positive.
             * @default false
             */
            not_a_sign: boolean;
            /**
             * @description Parts of engine tracks, in order of frames, disjoint.
             * @default []
             */
            segments: components["schemas"]["Segment"][];
            /** @description By ordinal. */
            keys: {
                [key: string]: components["schemas"]["KeyFrame"];
            };
            /** @default [] */
            notes: components["schemas"]["Note"][];
            /**
             * @description Deleted, or merged into another.
             * @default false
             */
            gone: boolean;
            merged_into: string | null;
            /** @description Attributes of the whole track; those of key frames have precedence. */
            attributes?: {
                [key: string]: boolean | number | string;
            };
            /**
             * @description A region to ignore: exports mark it if their format can, and training does not use it.
             * @default false
             */
            ignore?: boolean;
        };
        /** @description One event, as a sentence. */
        TrackEvent: {
            frame: number;
            kind: string;
            text: string;
        };
        /** @description Operations, newest first. */
        TrackHistory: {
            key: string;
            happened: components["schemas"]["Happened"][];
            /** @description Request rows before this number for older operations; None: there are none. */
            more: number | null;
        };
        /** @description One track frame by frame, one column per property. Null: the step did not take place. */
        TrackLane: {
            id: number;
            frame: number[];
            source: number[];
            box: [
                number,
                number,
                number,
                number
            ][];
            score: (number | null)[];
            raw_score: (number | null)[];
            prior: (number | null)[];
            l_positive: (number | null)[];
            /** @description 1 / max(symmetry_magnitude, symmetry_floor). */
            symmetry: (number | null)[];
            symmetry_magnitude: (number | null)[];
            hash_distance: (number | null)[];
            position_distance: (number | null)[];
            confident: (boolean | null)[];
            /** @description SVM. */
            decision: (number | null)[];
            probability: (number | null)[];
            /** @description S_t, px. */
            scale: (number | null)[];
            /** @description W_t. */
            weight: (number | null)[];
            /** @description Labels with the most votes, the winner first; -1: the video's set lacks the engine's class. */
            classes: number[];
            /** @description The engine's name of each of them that the set lacks. */
            words: (string | null)[];
            /** @description Fused share of each of `classes`, 0..1. */
            votes: (number[] | null)[];
            /** @description P(c | x_t) of each of `classes`. */
            probabilities: (number[] | null)[];
            /** @description Label from each frame's crop alone, as in ``classes``. */
            top: (number | null)[];
            /** @description The engine's name of it, if the set lacks it. */
            top_word: (string | null)[];
            top_probability: (number | null)[];
            /** @description Samples learned. */
            learned: number[];
            unlearned: number[];
            events: components["schemas"]["TrackEvent"][];
            tau: number;
            /** @description The run's parameter: smaller values of symmetry_magnitude count as this in `symmetry`. */
            symmetry_floor: number;
        };
        /** @description Result of an action. */
        TracksDone: {
            changed: number;
            /** @description Operations, for an undo. */
            operations: components["schemas"]["Operation-Output"][];
            stayed: number;
            /** @description The first tracks that were not changed, with reasons. */
            sentences: string[];
            /** @description Current state of the changed tracks, without those that are deleted or not in the tables yet. */
            tracks: components["schemas"]["FoundTrack"][];
        };
        /** @description All sources. */
        TrainingSources: {
            reviews: components["schemas"]["ReviewSource"][];
            exports: components["schemas"]["ExportAge"][];
        };
        /** @description New place of a waiting run in the queue. */
        Turn: {
            /** @description Run that it goes before; null: after all waiting runs. */
            before?: string | null;
        };
        /** @description Undo an operation. */
        Undo: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            name: "undo";
            op_id: string;
        };
        /** @description Undo the change that made a version. */
        UndoChange: {
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "undo";
            version: number;
        };
        /** @description Operations to undo. */
        UndoRequest: {
            author?: string | null;
            operations: components["schemas"]["app__search__actions__Operation"][];
        };
        /** @description A run whose tracks the search cannot read. */
        Unreadable: {
            run: string;
            run_name: string;
            video_name: string;
            message: string;
        };
        /** @description Change the fields that are sent; null removes a value. */
        UpdateLabel: {
            /** @default  */
            short?: string;
            aliases?: string[];
            /**
             * @default other
             * @enum {string}
             */
            shape?: "triangle" | "inverted triangle" | "circle" | "octagon" | "diamond" | "rectangle" | "other";
            /**
             * @default other
             * @enum {string}
             */
            category?: "prohibitory" | "mandatory" | "danger" | "priority" | "information" | "direction" | "additional" | "other";
            attributes?: components["schemas"]["NewAttribute"][];
            size_mm?: number | null;
            mirror?: string | null;
            /**
             * @default sign
             * @enum {string}
             */
            teach?: "sign" | "background" | "ignore";
            colour?: string | null;
            pinned?: number | null;
            /**
             * @description discriminator enum property added by openapi-typescript
             * @enum {string}
             */
            type: "update";
            id: number;
            name?: string | null;
        };
        /** @description The set to use from now on. */
        UseSet: {
            set: string;
        };
        /** @description The set that the video is to use; null: the library's default. */
        UseSetInVideo: {
            set: string | null;
        };
        /** @description One video of the library. */
        VideoView: {
            /** @description SHA-256. */
            id: string;
            name: string;
            path: string;
            /** @description Bytes. */
            size: number;
            state: string;
            error: string | null;
            /** @description Whether the file is missing. */
            missing: boolean;
            sample: boolean;
            width: number | null;
            height: number | null;
            /** @description Width of a pixel by its height, for display; boxes are in stored pixels. */
            pixel_ratio: number;
            frames: number | null;
            /** @description S. */
            duration: number | null;
            rate: number | null;
            codec: string | null;
            warnings: string[];
            /** @description ISO 8601. */
            created: string;
            /** @description Key of its own label set; None: the library's default. */
            label_set: string | null;
            tags: string[];
            /** @description Number of runs. */
            runs: number;
            latest_run: string | null;
            /** @description Review of the latest complete run: existing tracks, and accepted or rejected ones. */
            review: components["schemas"]["ReviewProgress"];
        };
        /** @description All videos. */
        Videos: {
            videos: components["schemas"]["VideoView"][];
        };
        /** @description A track in the revision that the person has seen. */
        WantedTrack: {
            run: string;
            key: string;
            revision: number;
        };
        /** @description The work of a person in the last 30 days. */
        Worker: {
            name: string;
            /** @description None: an author without an account, for example from before the library had people. */
            role: ("viewer" | "annotator" | "reviewer" | "admin") | null;
            /** @description Number of tracks accepted or rejected. */
            decided: number;
            /** @description Number of tracks rejected. */
            rejected: number;
            /** @description Time between operations; of a longer break five minutes. */
            hours: number;
            /** @description Number of assignments that are not done. */
            assigned: number;
            /** @description Number of assignments that wait for a reviewer. */
            in_review: number;
        };
        /** @description One operation of one person. */
        app__api__edits__Operation: {
            op_id: string;
            author: string;
            command: components["schemas"]["CreateTrack"] | components["schemas"]["SetBox"] | components["schemas"]["RelabelTrack"] | components["schemas"]["RelabelBox"] | components["schemas"]["Merge"] | components["schemas"]["Split"] | components["schemas"]["DeleteFrom"] | components["schemas"]["DeleteTrack"] | components["schemas"]["RestoreTrack"] | components["schemas"]["AddKey"] | components["schemas"]["RemoveKey"] | components["schemas"]["Interpolate"] | components["schemas"]["Follow"] | components["schemas"]["SetOccluded"] | components["schemas"]["SetOutside"] | components["schemas"]["SetNotASign"] | components["schemas"]["SetIgnore"] | components["schemas"]["SetAttribute"] | components["schemas"]["SetReview"] | components["schemas"]["ReviewTracks"] | components["schemas"]["AddNote"] | components["schemas"]["EditNote"] | components["schemas"]["RemoveNote"] | components["schemas"]["Undo"] | components["schemas"]["Redo"];
        };
        /** @description An action's operation in the log of one run. */
        app__search__actions__Operation: {
            run: string;
            op_id: string;
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export type operations = Record<string, never>;

#!/bin/bash
# The phase whose lanes hold the most vehicles that have halted, in a shell with jq.
while read -r question; do
    case $(jq -r .event <<<"$question") in
    begin)
        phases=$(jq -c '[.signals[].phases | map(.lanes)]' <<<"$question")
        echo '{}'
        ;;
    act)
        jq -c --argjson phases "$phases" '{phases: [.signals, $phases] | transpose | map(
            .[0].queue as $queue | .[1] | map(map($queue[.]) | add // 0) | index(max))}' <<<"$question"
        ;;
    end) exit ;;
    esac
done

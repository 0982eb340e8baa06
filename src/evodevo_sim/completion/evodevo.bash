# Completion of `ros2 run evodevo_sim ...` and `ros2 run evodevo_ga ...` in bash.  What completed `ros2` before completes all else.

_evodevo_before="$(complete -p ros2 2>/dev/null | sed -n 's/.* -F \([^ ]*\) .*/\1/p')"
[ "$_evodevo_before" = _evodevo_ros2 ] && _evodevo_before=""

_evodevo_ros2() {
    local current="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD-1]}" package="${COMP_WORDS[2]:-}" words=""
    COMPREPLY=()
    if [ "$COMP_CWORD" -gt 2 ] && [ "${COMP_WORDS[1]}" = run ] && declare -F "_evodevo_words_$package" >/dev/null; then
        if [ "$COMP_CWORD" -eq 3 ]; then
            words="$("_evodevo_words_$package" "" "")"
        else
            local name="${COMP_WORDS[3]}"
            case "$previous" in -?*) words="$("_evodevo_words_$package" "$name" "$previous")" ;; esac
            if [ -z "$words" ]; then
                case "$current" in
                    -*) words="$("_evodevo_words_$package" "$name" "")" ;;
                    *) words="$("_evodevo_words_$package" "$name" "-")"; [ "$COMP_CWORD" -gt 4 ] && words="<files>" ;;
                esac
            fi
        fi
    elif [ -n "${_evodevo_before:-}" ]; then
        "$_evodevo_before" "$@"
        return
    elif [ "$COMP_CWORD" -eq 1 ]; then
        words="run pkg"
    elif [ "$COMP_CWORD" -eq 2 ] && [ "${COMP_WORDS[1]}" = run ]; then
        words="$(declare -F | sed -n 's/.* _evodevo_words_//p' | tr '\n' ' ')"
    fi
    case " $words " in *" <files> "*) mapfile -t COMPREPLY < <(compgen -f -- "$current") ;; esac
    words="${words//<files>/}"
    mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -W "${words//<any>/}" -- "$current")
}
complete -o filenames -F _evodevo_ros2 ros2

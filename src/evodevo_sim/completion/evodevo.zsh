# Completion of `ros2 run evodevo_sim ...` and `ros2 run evodevo_ga ...` in zsh.  What completed `ros2` before completes all else.

_evodevo_ros2() {
    local package="${words[3]}" name="${words[4]}" current="${words[CURRENT]}" previous="${words[CURRENT-1]}" found=""
    if (( CURRENT > 3 )) && [[ "${words[2]}" == run ]] && (( $+functions[_evodevo_words_$package] )); then
        if (( CURRENT == 4 )); then
            found="$(_evodevo_words_$package "" "")"
        else
            [[ "$previous" == -?* ]] && found="$(_evodevo_words_$package "$name" "$previous")"
            if [[ -z "$found" ]]; then
                if [[ "$current" == -* ]]; then
                    found="$(_evodevo_words_$package "$name" "")"
                else
                    found="$(_evodevo_words_$package "$name" "-")"
                    (( CURRENT > 5 )) && found="<files>"
                fi
            fi
        fi
    elif [[ -n "${_evodevo_before:-}" ]]; then
        $_evodevo_before "$@"
        return
    elif (( CURRENT == 2 )); then
        found="run pkg"
    elif (( CURRENT == 3 )) && [[ "${words[2]}" == run ]]; then
        found="${(k)functions[(I)_evodevo_words_*]//_evodevo_words_/}"
    fi
    local -a fitting=(${${=found}:#<*>})
    (( $#fitting )) && compadd -- $fitting
    [[ " $found " == *" <files> "* ]] && _files
    return 0
}

if [[ -o interactive ]] && (( ! $+functions[compdef] )); then
    autoload -Uz compinit && compinit -u
fi
if (( $+functions[compdef] )); then
    [[ "${_comps[ros2]:-}" != _evodevo_ros2 ]] && _evodevo_before="${_comps[ros2]:-}"
    compdef _evodevo_ros2 ros2
fi
